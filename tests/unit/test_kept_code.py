"""Compiled code in numba's cache: damaged in every way, it is compiled anew and right again."""

import inspect
import itertools
import os
import pickle
import random
import subprocess
import sys
import textwrap
import types

import pytest
import rail_cosim.kept_code
import rail_quantities.kept_code
from numba.core.caching import IndexDataCacheFile
from product import PATIENCE
from rail_quantities.kept_code import CheckedFiles

MODULE = """
import numba
from rail_quantities.kept_code import with_checksums

def compiled(function):
    return with_checksums(numba.njit(cache=True)(function))

@compiled
def inner(x):
    return 3 * x + 1

@compiled
def outer(x):
    return inner(x) * inner(x)
"""
USE = """
import kernels
print(kernels.outer(2), kernels.outer(0.5), end=" ")
print(sum(kernels.outer.stats.cache_hits.values()), sum(kernels.outer.stats.cache_misses.values()))
"""
RIGHT = "49 6.25"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "kernels.py").write_text(MODULE)
    assert use(tmp_path) == f"{RIGHT} 0 2"
    return tmp_path


def use(folder, code=USE):
    """Return what a new process prints."""
    path = os.pathsep.join([str(folder), *filter(None, sys.path)])
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def kept(folder, ending):
    return sorted(folder.glob(f"__pycache__/kernels.outer-*.{ending}"))


def test_whole_files_are_used(folder):
    assert len(kept(folder, "nbi")) == 1
    assert len(kept(folder, "nbc")) == 2
    assert use(folder) == f"{RIGHT} 2 0"


DAMAGE = {
    "cut in half": lambda content: content[: len(content) // 2],
    "cut by a byte": lambda content: content[:-1],
    "empty": lambda content: b"",
    "garbage": lambda content: random.Random(1).randbytes(len(content)),
    "longer": lambda content: content + b"\0",
    "bit in the middle": lambda content: flipped(content, len(content) // 2),
    "bit at the start": lambda content: flipped(content, 0),
    "bit at the end": lambda content: flipped(content, len(content) - 1),
}


def flipped(content, place):
    return content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :]


QUICK = {("nbi", "bit in the middle"), ("nbc", "cut in half")}
"""Of whole processes; test_no_byte_of_a_file_can_change_unnoticed has every byte in this one."""


@pytest.mark.parametrize(
    ("ending", "how"),
    [
        pytest.param(*case, marks=() if case in QUICK else pytest.mark.slow)
        for case in itertools.product(("nbi", "nbc"), DAMAGE)
    ],
)
def test_damaged_files_are_compiled_anew(folder, ending, how):
    for path in kept(folder, ending):
        path.write_bytes(DAMAGE[how](path.read_bytes()))
    assert use(folder) == f"{RIGHT} 0 2"
    assert use(folder) == f"{RIGHT} 2 0"


def test_no_byte_of_a_file_can_change_unnoticed(tmp_path):
    """Every single byte of both files: the entry is gone, or (never) right."""
    files = CheckedFiles(cache_path=str(tmp_path), filename_base="f", source_stamp=1)
    files.save("key", ["code", 1.5])
    assert files.load("key") == ["code", 1.5]
    for path in tmp_path.iterdir():
        good = path.read_bytes()
        for place in range(len(good)):
            path.write_bytes(flipped(good, place))
            assert files.load("key") is None
        path.write_bytes(good)
    assert files.load("key") == ["code", 1.5]


def test_code_of_one_signature_does_not_pass_for_another(tmp_path):
    """As two processes may leave it that save at the same time: one index, the other's code."""
    arguments = {"cache_path": str(tmp_path), "filename_base": "f", "source_stamp": 1}
    one, other = CheckedFiles(**arguments), CheckedFiles(**arguments)
    one.save("integers", "code for integers")
    (tmp_path / "f.nbi").unlink()
    other.save("reals", "code for reals")
    (data,) = tmp_path.glob("*.nbc")
    theirs = data.read_bytes()
    one.flush()
    one.save("integers", "code for integers")
    data.write_bytes(theirs)
    assert one.load("integers") is None
    one.save("integers", "code for integers")
    assert one.load("integers") == "code for integers"


def test_an_index_of_types_that_are_gone_is_begun_anew(tmp_path, monkeypatch):
    files = CheckedFiles(cache_path=str(tmp_path), filename_base="f", source_stamp=1)
    module = types.ModuleType("former")
    module.Kind = type("Kind", (), {"__module__": "former"})
    monkeypatch.setitem(sys.modules, "former", module)
    files.save(module.Kind, "code")
    assert files.load(module.Kind) == "code"
    monkeypatch.delitem(sys.modules, "former")
    assert files.load("key") is None
    files.save("key", "other code")
    assert files.load("key") == "other code"


def test_no_room_for_the_code_is_no_error(tmp_path):
    files = CheckedFiles(cache_path=str(tmp_path / "none"), filename_base="f", source_stamp=1)
    files.save("key", "code")
    assert files.load("key") is None


def test_files_are_still_those_that_numba_reads(tmp_path):
    files = CheckedFiles(cache_path=str(tmp_path), filename_base="f", source_stamp=1)
    files.save("key", "code")
    plain = IndexDataCacheFile(cache_path=str(tmp_path), filename_base="f", source_stamp=1)
    assert plain.load("key") == ("key", "code")
    (data,) = tmp_path.glob("*.nbc")
    assert pickle.loads(data.read_bytes()) == ("key", "code")


@pytest.mark.parametrize(
    ("packages", "least"), [("rail_vehicle, slab_track", 60), ("rail_cosim.march", 5)]
)
def test_all_compiled_functions_have_checksums(packages, least):
    code = f"""
    import gc, {packages}
    from numba.core.dispatcher import Dispatcher
    ours = ("rail_vehicle.", "slab_track.", "rail_cosim.")
    found = [f for f in gc.get_objects() if isinstance(f, Dispatcher)]
    ours = [f for f in found if f.py_func.__module__.startswith(ours)]
    print(len(ours), {{type(f._cache._cache_file).__name__ for f in ours}})
    """
    count, _, kinds = use(os.getcwd(), code).partition(" ")
    assert int(count) >= least
    assert kinds == "{'CheckedFiles'}"


@pytest.mark.parametrize("name", ["CheckedFiles", "_is_whole", "with_checksums"])
def test_the_master_has_the_same(name):
    """It must not load what FMUs carry, and so has a copy."""
    both = [getattr(m, name) for m in (rail_cosim.kept_code, rail_quantities.kept_code)]
    assert inspect.getsource(both[0]) == inspect.getsource(both[1])

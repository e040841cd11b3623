"""Packages of an FMU in the per-user cache."""

import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from rail_fmi import bundle

USE = (
    "import sys; sys.path.insert(0, sys.argv[1]); import bundle_of_test as b;"
    "b.prepare(globals(), {'tiny_pack': sys.argv[2]}); import tiny_pack, tiny_pack.inner;"
    "print(tiny_pack.__file__, tiny_pack.inner.VALUE)"
)


@pytest.fixture
def resources(tmp_path):
    """Make an FMU's resources with a small package."""
    pack = tmp_path / "resources" / "tiny_pack"
    pack.mkdir(parents=True)
    (pack / "__init__.py").write_text('"""Tiny."""\n')
    (pack / "inner.py").write_text("VALUE = 42\n" + "# filler\n" * 2000)
    (pack / "data.csv").write_bytes(b"1,2\r\n")
    shutil.copyfile(bundle.__file__, tmp_path / "resources" / "bundle_of_test.py")
    return tmp_path / "resources"


def use(resources: Path, cache: Path | str, digest: str = "") -> subprocess.CompletedProcess[str]:
    digest = digest or bundle.source_hash(resources / "tiny_pack")
    return subprocess.run(
        [sys.executable, "-c", USE, str(resources), digest],
        env=os.environ | {"RAIL_COSIM_CACHE": str(cache)},
        capture_output=True,
        text=True,
    )


def place(done: subprocess.CompletedProcess[str]) -> Path:
    assert done.returncode == 0, done.stderr
    name, value = done.stdout.split()
    assert value == "42"
    return Path(name)


def test_hash_sees_names_and_contents_only(resources):
    pack = resources / "tiny_pack"
    first = bundle.source_hash(pack)
    (pack / "__pycache__").mkdir()
    (pack / "__pycache__" / "inner.cpython-311.pyc").write_bytes(b"x")
    os.utime(pack / "inner.py", (0, 0))
    assert bundle.source_hash(pack) == first
    (pack / "data.csv").rename(pack / "other.csv")
    assert bundle.source_hash(pack) != first


def test_import_comes_from_the_cache_and_again(resources, tmp_path):
    cache = tmp_path / "cache"
    first = place(use(resources, cache))
    assert cache in first.parents
    stamp = first.with_name("inner.py").stat().st_mtime_ns
    moved = resources.rename(tmp_path / "another_extraction")
    assert place(use(moved, cache)) == first
    assert first.with_name("inner.py").stat().st_mtime_ns == stamp  # numba's cache needs that


def test_compiled_code_is_found_again_from_another_extraction(resources, tmp_path):
    (resources / "tiny_pack" / "inner.py").write_text(
        "import numba\n\n@numba.njit(cache=True)\ndef twice(x):\n    return 2 * x\n\n"
        "assert twice(21) == 42\nVALUE = sum(twice.stats.cache_hits.values())\n"
    )
    cache = tmp_path / "cache"
    assert use(resources, cache).stdout.split()[-1] == "0"
    moved = resources.rename(tmp_path / "another_extraction")
    assert use(moved, cache).stdout.split()[-1] == "1"


def test_damaged_entry_is_written_anew(resources, tmp_path):
    cache = tmp_path / "cache"
    inner = place(use(resources, cache)).with_name("inner.py")
    good = inner.read_text()
    for damage in (lambda: inner.write_text("VALUE = 13\n"), inner.unlink):
        damage()
        assert place(use(resources, cache)) == inner.with_name("__init__.py")
        assert inner.read_text() == good
    assert [path.name for path in (cache / "packages").iterdir()] == [inner.parent.parent.name]


def test_cache_that_cannot_be_written_is_done_without(resources, tmp_path):
    (tmp_path / "file").write_text("")
    assert place(use(resources, tmp_path / "file")).parent.parent == resources


def test_processes_may_fill_the_cache_at_once(resources, tmp_path):
    cache = tmp_path / "cache"
    with ThreadPoolExecutor(8) as pool:
        found = {place(done) for done in pool.map(lambda _: use(resources, cache), range(16))}
    assert len(found) == 1
    assert cache in found.pop().parents
    assert len(list((cache / "packages").iterdir())) == 1  # nothing half-made is left


def test_damaged_fmu_is_refused(resources, tmp_path):
    done = use(resources, tmp_path / "cache", "0" * 64)
    assert done.returncode == 1
    assert "the FMU is damaged" in done.stderr


def test_missing_library_is_named_with_the_remedy(resources, tmp_path):
    (resources / "tiny_pack" / "__init__.py").write_text("import no_such_library\n")
    done = use(resources, tmp_path / "cache")
    assert "No module named 'no_such_library'" in done.stderr
    assert "-m pip install -r" in done.stderr


def test_loaded_package_of_another_version_is_refused(monkeypatch, resources):
    monkeypatch.syspath_prepend(str(resources))
    monkeypatch.delitem(sys.modules, "tiny_pack", raising=False)
    import tiny_pack  # type: ignore[import-not-found]

    good = bundle.source_hash(resources / "tiny_pack")
    bundle.prepare({}, {"tiny_pack": good})
    (resources / "tiny_pack" / "inner.py").write_text("VALUE = 43\n")
    bundle.prepare({}, {"tiny_pack": good})  # what counts is what was loaded
    with pytest.raises(bundle.BundleError, match="'tiny_pack' is already loaded from") as caught:
        bundle.prepare({}, {"tiny_pack": "f" * 64})
    assert "Remedy: rebuild the FMUs" in str(caught.value)
    monkeypatch.delitem(sys.modules, tiny_pack.__name__)


def test_message_is_safe_for_the_logger():
    assert repr(bundle.BundleError("100 %s \udcff")) == "100 %%s \\udcff"


@pytest.mark.parametrize(
    ("platform", "variable", "wanted"),
    [
        ("linux", "XDG_CACHE_HOME", "rail-cosim"),
        ("win32", "LOCALAPPDATA", "rail-cosim/Cache"),
    ],
)
def test_cache_follows_the_platform(monkeypatch, tmp_path, platform, variable, wanted):
    monkeypatch.delenv("RAIL_COSIM_CACHE", raising=False)
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setenv(variable, str(tmp_path))
    assert bundle.cache_folder() == tmp_path / wanted


def test_old_python_is_refused_before_anything_is_imported(resources, monkeypatch, capsys):
    monkeypatch.setattr(sys, "version_info", (3, 10, 12, "final", 0))
    with pytest.raises(
        bundle.BundleError, match=r"needs Python 3\.11 or newer, .* Python 3\.10\.12"
    ):
        bundle.prepare({}, {"a_package_that_is_nowhere": ""})
    assert "this host embeds Python 3.10.12" in capsys.readouterr().err

"""Make faults in a copy of the sources, one at a time, and see whether the tests notice.

``python tests/mutations/check.py [--count 10] [--seed 1] [--area vehicle] [--minutes 60]``. The
faults are those of cosmic-ray (exchanged operators, lost signs) at places drawn at random in each
area of ``areas.toml``, so they follow the sources however these are rewritten. The status is 1 if
fewer than eight tenths are noticed, 2 if the tests fail without any fault. Those that survive are
printed: each is a missing test, or changes nothing.
"""

import argparse
import itertools
import os
import random
import shlex
import shutil
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cosmic_ray.ast import ast_nodes, get_ast_from_path
from cosmic_ray.ast.ast_query import ASTQuery
from cosmic_ray.modules import find_modules
from cosmic_ray.mutating import mutate_and_test
from cosmic_ray.plugins import get_operator
from cosmic_ray.testing import run_tests
from cosmic_ray.work_item import MutationSpec, TestOutcome

ROOT = Path(__file__).parents[2]
PACKAGES = ("fmus/common", "fmus/track", "fmus/vehicle", "master", "tests/support")
OPERATORS = (
    "core/ReplaceBinaryOperator_Add_Sub",
    "core/ReplaceBinaryOperator_Sub_Add",
    "core/ReplaceBinaryOperator_Mul_Div",
    "core/ReplaceBinaryOperator_Div_Mul",
    "core/ReplaceUnaryOperator_USub_UAdd",
    "core/ReplaceComparisonOperator_Lt_Gt",
    "core/ReplaceComparisonOperator_Gt_Lt",
    "core/AddNot",
)
WANTED = 0.8
"""Some faults change nothing, such as another order of two springs alike."""
_LEFT_OUT = shutil.ignore_patterns(
    ".git", ".venv", ".*_cache", ".hypothesis", "__pycache__", "results", "build"
)
CORES = ("rail_vehicle", "slab_track", "rail_cosim")
_LONGEST = 3000.0
"""Time for the tests of one fault, s; a fault that makes them hang is noticed, too."""


def areas() -> list[dict[str, Any]]:
    """Return the areas of ``areas.toml``."""
    return tomllib.loads(Path(__file__).with_name("areas.toml").read_text("utf-8"))["area"]


def faults(tree: Path, sources: list[str]) -> Iterator[MutationSpec]:
    """Yield all faults that there can be in functions of the sources, in a fixed order."""
    for path in sorted(find_modules([tree / source for source in sources])):
        nodes = list(ast_nodes(get_ast_from_path(path)))
        for name in OPERATORS:
            operator = get_operator(name)()
            places = ((n, place) for n in nodes for place in operator.mutation_positions(n))
            for occurrence, (node, (start, end)) in enumerate(places):
                if function := ASTQuery(node).get_definition_name():
                    yield MutationSpec(path, name, occurrence, start, end, {}, function)


def command(tree: Path, tests: list[str]) -> str:
    """Return the command that compiles what was changed and runs the tests of an area."""
    files = [str(path) for pattern in tests for path in sorted(tree.glob(pattern))]
    compiled = shlex.join([sys.executable, "-m", "rail_native", *CORES])
    tested = shlex.join([sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:xdist", *files])
    return shlex.join(["sh", "-c", f"{compiled} && {tested}"])


def tried(tree: Path, spec: MutationSpec, tests: str) -> bool:
    """Make a fault and run the tests; print what became of it, and say if it was noticed."""
    begin = time.monotonic()
    found = mutate_and_test([spec], tests, _LONGEST)
    noticed = found.test_outcome == TestOutcome.KILLED
    verdict = "noticed " if noticed else str(found.test_outcome and found.test_outcome.value)
    place = f"{spec.module_path.relative_to(tree)}:{spec.start_pos[0]} {spec.definition_name}"
    what = spec.operator_name.rpartition("/")[2]
    print(f"{verdict} {time.monotonic() - begin:4.0f} s  {place} {what}", flush=True)
    if not noticed:
        print(found.diff or found.output, flush=True)
    return noticed


def main() -> int:
    """Run; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10, help="faults in each area")
    parser.add_argument("--seed", type=int, default=1, help="other faults for another number")
    parser.add_argument("--area", action="append", choices=[area["name"] for area in areas()])
    parser.add_argument("--minutes", type=float, default=60.0, help="no new fault after these")
    options = parser.parse_args()
    verdicts, end = [], time.monotonic() + 60.0 * options.minutes
    with tempfile.TemporaryDirectory(prefix="mutations_") as name:
        folder, tree = Path(name), Path(name, "tree")
        shutil.copytree(ROOT, tree, ignore=_LEFT_OUT)
        paths = os.pathsep.join(str(tree / package) for package in PACKAGES)
        os.environ |= {"PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(folder / "numba")}
        os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
        os.chdir(tree)
        for area in areas():
            if options.area and area["name"] not in options.area:
                continue
            tests = command(tree, area["tests"])
            outcome, text = run_tests(tests, _LONGEST)
            if outcome != TestOutcome.SURVIVED:
                print(f"{area['name']}: the tests fail without any fault:\n{text}", file=sys.stderr)
                return 2
            possible = list(faults(tree, area["sources"]))
            drawn = random.Random(options.seed).sample(possible, min(options.count, len(possible)))
            print(f"{area['name']}: {len(drawn)} of {len(possible)} faults", flush=True)
            in_time = itertools.takewhile(lambda _: time.monotonic() < end, drawn)
            verdicts += [tried(tree, spec, tests) for spec in in_time]
    print(f"{sum(verdicts)} of {len(verdicts)} noticed")
    return 0 if verdicts and sum(verdicts) >= WANTED * len(verdicts) else 1


if __name__ == "__main__":
    sys.exit(main())

"""Fuzz what reads files and bytes from elsewhere, by atheris.

``python tests/fuzz/run.py [--seconds 60] [TARGET ...]``; the status is 1 if anything was found.
Without atheris (the extra ``fuzz``) it says so, and the status is 0.
"""

import argparse
import importlib.util
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
NAMES = ("profile", "irregularity", "case", "sweep", "ssv", "ssp", "description", "state")
_INSTRUMENTED = ["rail_cosim", "rail_fmi", "rail_quantities", "slab_track.contact.profile_file",
                 "slab_track.irregularity.files", "tomllib"]  # fmt: skip
_MEGABYTES, _SLOWEST = 3000, 20


def fuzz_one(name: str, arguments: list[str]) -> None:
    """Fuzz one target in this process; does not return."""
    import atheris

    sys.path.insert(0, str(HERE))
    with atheris.instrument_imports(include=_INSTRUMENTED):
        from targets import TARGETS
    folder = Path(arguments[0])
    for number, seed in enumerate(TARGETS[name].seeds()):
        (folder / f"seed{number}").write_bytes(seed)
    atheris.Setup([sys.argv[0], *arguments], TARGETS[name].check)
    atheris.Fuzz()


def run(name: str, seconds: int, kept: Path) -> tuple[int, int, str]:
    """Fuzz one target in a process of its own; return status, executions and what it said."""
    with tempfile.TemporaryDirectory(prefix=f"corpus_{name}_") as corpus:
        done = subprocess.run(
            [
                sys.executable, __file__, "--one", name, corpus, f"-max_total_time={seconds}",
                "-max_len=4096", f"-timeout={_SLOWEST}", f"-rss_limit_mb={_MEGABYTES}",
                "-print_final_stats=1", f"-artifact_prefix={kept}/{name}-", "-seed=1",
            ],
            capture_output=True, text=True, errors="replace", timeout=seconds + 300,
        )  # fmt: skip
    text = done.stdout + done.stderr
    counts = re.findall(r"stat::number_of_executed_units:\s*(\d+)", text) or re.findall(
        r"#(\d+)\s", text
    )
    return done.returncode, int(counts[-1]) if counts else 0, text


def main() -> int:
    """Run the targets one after the other; return the exit status."""
    if sys.argv[1:2] == ["--one"]:
        fuzz_one(sys.argv[2], sys.argv[3:])
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("target", nargs="*", choices=[[], *NAMES], help="default: all")
    parser.add_argument("--seconds", type=int, default=60, help="of each target")
    parser.add_argument("--findings", type=Path, default=Path("results/fuzz"))
    options = parser.parse_args()
    if importlib.util.find_spec("atheris") is None:
        print("atheris is not installed (pip install 'rail-cosim[fuzz]'): nothing was fuzzed")
        return 0
    options.findings.mkdir(parents=True, exist_ok=True)
    found = 0
    for name in options.target or NAMES:
        status, count, text = run(name, options.seconds, options.findings.absolute())
        found += status != 0
        print(f"{name:13} {count:9} executions, {'a finding' if status else 'no findings'}",
              flush=True)  # fmt: skip
        if status:
            print(text[-4000:])
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

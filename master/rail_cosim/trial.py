"""A short run of one FMU alone, in a process of its own, to see whether it keeps its word."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

from rail_cosim.builder import child_environment
from rail_cosim.contract import Finding, Role, role_of, terminal_numbers
from rail_cosim.errors import RailCosimError
from rail_cosim.fmu import FmuSlave
from rail_cosim.name_map import described

STEP, STEPS = 1e-4, 20
LONGEST = 300.0  # s; kernels may have to be compiled
_SLOWEST = 1.0  # m/s; below it a wheel's spin says nothing

Text = tuple[str, str]


def trial_findings(path: Path, names: Path | None = None) -> list[Finding]:
    """Run an FMU for a few steps from its own start values and say what went wrong.

    It runs in a process of its own, so whatever it does there, a crash or an
    endless loop, is a finding too. ``names`` is its name map, if it has one.
    """
    files = [path] if names is None else [path, names]
    command = [sys.executable, "-m", "rail_cosim.trial", *map(str, files)]
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=LONGEST,
            env=child_environment(),
            check=False,
        )
    except subprocess.TimeoutExpired:
        return [_fault("trial run", f"is not over after {LONGEST:g} s")]
    lines = done.stdout.splitlines()
    found = [_fault(*json.loads(line)) for line in lines if line.startswith("[")]
    if done.returncode != 0:
        last = done.stderr.strip().splitlines()[-1:] or ["it said nothing"]
        how = f"signal {-done.returncode}" if done.returncode < 0 else f"status {done.returncode}"
        found.append(_fault("trial run", f"its process ended with {how}: {last[0]}"))
    return found


def _fault(subject: str, text: str) -> Finding:
    return Finding(level="fault", subject=subject, text=text)


def try_out(path: Path, names: Path | None = None) -> Iterator[Text]:
    """Run an FMU alone in this process; yield subject and text of each fault."""
    try:
        with FmuSlave(path, "trial", description=described(path, names)) as slave:
            slave.setup(0.0, STEPS * STEP)
            slave.enter_initialization()
            slave.exit_initialization()
            role = role_of(slave.variables)
            before = _outputs(slave)
            yield from _not_finite(before, "at the start")
            yield from _signs(before, role)
            for step in range(STEPS):
                slave.do_step(step * STEP, STEP)
            after = _outputs(slave)
            yield from _not_finite(after, f"after {STEPS} steps of {STEP:g} s")
            yield from _way(before, after, role)
            if slave.description.can_save_state:
                yield from _rollback(slave)
    except RailCosimError as error:
        yield "trial run", str(error).partition("\n")[0]


def _outputs(slave: FmuSlave) -> dict[str, float]:
    variables = slave.variables.values()
    names = [v.name for v in variables if v.causality == "output" and v.kind == "real"]
    return {name: float(value) for name, value in slave.get(names).items()}


def _not_finite(values: dict[str, float], when: str) -> Iterator[Text]:
    for name, value in values.items():
        if not math.isfinite(value):
            yield name, f"is {value:g} {when}"


def _signs(values: dict[str, float], role: Role | None) -> Iterator[Text]:
    """Compare with the contract's frame: forward is positive, down is positive."""
    numbers = terminal_numbers(values)
    places = [values.get(f"wheelset[{i}].longitudinal_position", math.nan) for i in numbers]
    for i, (ahead, behind) in enumerate(pairwise(places), start=2):
        if role == "vehicle" and not ahead > behind:
            text = (
                f"is {behind:g} m, not behind the one before ({ahead:g} m); they count from ahead"
            )
            yield f"wheelset[{i}].longitudinal_position", text
    for i in numbers:
        speed = values.get(f"wheelset[{i}].longitudinal_velocity", 0.0)
        spin = values.get(f"wheelset[{i}].pitch_rate", 0.0)
        if role == "vehicle" and abs(speed) > _SLOWEST and not spin * speed < 0.0:
            text = f"is {spin:g} rad/s at {speed:g} m/s; rolling is minus speed over radius"
            yield f"wheelset[{i}].pitch_rate", text
        force = values.get(f"wheelset[{i}].contact.vertical_force", 0.0)
        if role == "track" and force > 0.0:
            text = f"is {force:g} N at rest; it carries the wheelset, upwards, which is negative"
            yield f"wheelset[{i}].contact.vertical_force", text


def _way(before: dict[str, float], after: dict[str, float], role: Role | None) -> Iterator[Text]:
    for i in terminal_numbers(before) if role == "vehicle" else ():
        place, rate = (f"wheelset[{i}].longitudinal_{n}" for n in ("position", "velocity"))
        if place not in before or rate not in before:
            continue
        moved = after[place] - before[place]
        wanted = 0.5 * (before[rate] + after[rate]) * STEPS * STEP
        if abs(moved - wanted) > 0.01 * abs(wanted) + 1e-6:
            yield place, f"moves by {moved:g} m where its velocity says {wanted:g} m"


def _rollback(slave: FmuSlave) -> Iterator[Text]:
    state = slave.save_state()
    results: list[dict[str, float]] = []
    for _ in range(2):
        slave.do_step(STEPS * STEP, STEP)
        results.append(_outputs(slave))
        slave.restore_state(state)
    slave.free_state(state)
    for name, value in results[0].items():
        if results[1][name] != value:
            yield name, "is another after the state was set back and the step made again"


def main() -> None:
    """Print the faults of the FMU on the command line, perhaps with its name map, as JSON lists."""
    for fault in try_out(*map(Path, sys.argv[1:])):
        print(json.dumps(fault), flush=True)


if __name__ == "__main__":
    main()

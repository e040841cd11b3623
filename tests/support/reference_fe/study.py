"""Converged amplitudes of the steady state, for other models to be checked against.

Regenerate with ``PYTHONPATH=tests/support python -m reference_fe.study FILE`` (some 40 minutes).
"""

import argparse
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np

from .parameters import ReferenceTrack, ReferenceVehicle, SingleWheel
from .simulation import ReferenceResult, simulate

SPEEDS_KMH = (100.0, 170.0, 200.0, 300.0, 400.0)
PAD_STIFFNESSES = (40e6, 140e6, 200e6)
NOMINAL_PAD_DAMPING, LOW_PAD_DAMPING = 52e3, 10e3
VEHICLES = {"single_wheel": SingleWheel(), "vehicle": ReferenceVehicle()}
STEADY_DEFECT = 2e-3
"""A run counts as periodic below this change from one slab to the next."""


@dataclass(frozen=True, kw_only=True)
class Resolution:
    """Mesh and largest step of a run."""

    rail_elements_per_bay: int
    slab_elements_per_bay: int
    slab_elements_across: int
    step: float

    def of(self, track: ReferenceTrack) -> ReferenceTrack:
        """Give the track this mesh."""
        return replace(
            track,
            rail_elements_per_bay=self.rail_elements_per_bay,
            slab_elements_per_bay=self.slab_elements_per_bay,
            slab_elements_across=self.slab_elements_across,
        )


# Wheels pass 12 rail elements per bay faster than 500 Hz from 100 km/h on; coarser meshes leave
# their own ripple in the band there.
COARSE = Resolution(
    rail_elements_per_bay=8, slab_elements_per_bay=3, slab_elements_across=8, step=5e-5
)
MEDIUM = Resolution(
    rail_elements_per_bay=12, slab_elements_per_bay=4, slab_elements_across=10, step=2.5e-5
)
FINE = Resolution(
    rail_elements_per_bay=16, slab_elements_per_bay=5, slab_elements_across=12, step=1.25e-5
)


def steady_run(
    track: ReferenceTrack,
    vehicle: SingleWheel | ReferenceVehicle,
    speed_kmh: float,
    resolution: Resolution,
) -> ReferenceResult:
    """Run until the start has died away: longer, and farther from the ends, with soft damping."""
    low = track.pad_damping < 30e3
    speed = speed_kmh / 3.6
    duration = 2.2 if low else 0.7
    return simulate(
        resolution.of(track),
        vehicle,
        speed,
        max(speed * duration, 8 * track.pitch),
        step=resolution.step,
        margin=25.0 if low else 15.0,
    )


def amplitude_case(
    name: str, speed_kmh: float, pad_stiffness: float, pad_damping: float
) -> dict[str, object]:
    """Amplitudes at two resolutions; their difference bounds the finer one's error."""
    track = ReferenceTrack(pad_stiffness=pad_stiffness, pad_damping=pad_damping)
    # Lightly damped runs are long: one resolution lower each.
    levels = (COARSE, MEDIUM) if pad_damping < 30e3 else (MEDIUM, FINE)
    check, best = (steady_run(track, VEHICLES[name], speed_kmh, level) for level in levels)
    force = best.amplitude(best.wheel_force)[:, 0]
    acceleration = best.amplitude(best.wheelset_acceleration)
    change = np.abs(check.amplitude(check.wheel_force)[:, 0] / force - 1)
    defect = best.periodicity_defect(best.wheel_force)[:, 0]
    return {
        "vehicle": name,
        "speed_kmh": speed_kmh,
        "pad_stiffness": pad_stiffness,
        "pad_damping": pad_damping,
        "wheel_force_amplitude": [float(v) for v in force.round(2)],
        "wheelset_acceleration_amplitude": [float(v) for v in acceleration.round(5)],
        "smallest_wheel_force": float(best.wheel_force[len(best.time) // 2 :].min().round(1)),
        "error_estimate": float(f"{max(change + defect):.1e}"),
        "periodicity_defect": float(f"{defect.max():.1e}"),
        "steady": bool(defect.max() < STEADY_DEFECT),
    }


def resonance_case(pad_stiffness: float) -> dict[str, object]:
    """Speed of the largest wheelset acceleration of a single wheel, nominal pad damping."""
    track = ReferenceTrack(pad_stiffness=pad_stiffness)

    def amplitude(speed_kmh: float, resolution: Resolution = MEDIUM) -> float:
        run = steady_run(track, SingleWheel(), speed_kmh, resolution)
        return float(run.amplitude(run.wheelset_acceleration)[0])

    coarse = np.arange(80.0, 261.0, 15.0)
    centre = coarse[np.argmax([amplitude(v, COARSE) for v in coarse])]
    speeds = centre + np.arange(-12.0, 13.0, 4.0)
    values = np.array([amplitude(v) for v in speeds])
    top = int(np.clip(values.argmax(), 1, len(values) - 2))
    near = np.polynomial.Polynomial.fit(speeds[top - 1 : top + 2], values[top - 1 : top + 2], 2)
    peak = float(near.deriv().roots()[0])  # the parabola's own height would be some 1 % low
    return {
        "pad_stiffness": pad_stiffness,
        "pad_damping": NOMINAL_PAD_DAMPING,
        "resonance_speed_kmh": round(peak, 2),
        "wheelset_acceleration_amplitude": round(amplitude(peak), 4),
    }


def amplitude_cases() -> Iterator[dict[str, object]]:
    """Go through the table; low damping for the single wheel only."""
    for name, damping in (
        ("single_wheel", NOMINAL_PAD_DAMPING),
        ("vehicle", NOMINAL_PAD_DAMPING),
        ("single_wheel", LOW_PAD_DAMPING),
    ):
        for stiffness, speed in product(PAD_STIFFNESSES, SPEEDS_KMH):
            yield amplitude_case(name, speed, stiffness, damping)


def main() -> None:
    """Write the table as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    path = parser.parse_args().file
    table: dict[str, object] = {
        "command": f"PYTHONPATH=tests/support python -m reference_fe.study {path.as_posix()}",
        "meaning": "HD line, Table 2 but for the pads; half the peak-to-peak over the last slab "
        "pitch, Fourier terms up to 500 Hz; wheel force in N per wheel, acceleration in m/s2, "
        "one value per wheelset; error estimate: change from the next coarser mesh and step, plus "
        "change from slab to slab, both relative, of the wheel force",
    }
    cases: list[dict[str, object]] = []
    for case in amplitude_cases():
        cases.append(case)
        print(json.dumps(case), flush=True)
        path.write_text(json.dumps({**table, "cases": cases}, indent=1) + "\n")
    table["resonance"] = [resonance_case(stiffness) for stiffness in PAD_STIFFNESSES]
    path.write_text(json.dumps({**table, "cases": cases}, indent=1) + "\n")


if __name__ == "__main__":
    main()

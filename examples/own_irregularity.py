"""A measured line of your own: a file by distance, here a dip of 2 mm in 3 m under both rails.

python examples/own_irregularity.py [METRES]
"""

import sys
from pathlib import Path

import numpy as np
import rail_cosim

DEPTH, LENGTH, STEP = 2.0, 3.0, 0.05  # mm (down is positive), m, m


def write_dip(path: Path, place: float, distance: float) -> None:
    """Write a full cosine wave of DEPTH from ``place`` on, in a line of ``distance`` metres."""
    way = np.arange(0.0, distance + 30.0, STEP)
    inside = (way > place) & (way < place + LENGTH)
    wave = 0.5 * DEPTH * (1.0 - np.cos(2.0 * np.pi * (way - place) / LENGTH))
    dip = np.where(inside, wave, 0.0)
    table = np.column_stack([way, dip, dip])
    heading = "distance [m], left_vertical [mm], right_vertical [mm]"
    np.savetxt(path, table, fmt="%.4f", delimiter=", ", header=heading, comments="")


def main(distance: float) -> None:
    """Run ``distance`` metres over the dip and without it."""
    path = Path("my_line.csv")
    write_dip(path, 0.5 * distance, distance)
    for name, line in (("smooth", None), (str(path), path)):
        run = rail_cosim.run(
            speed=300,
            distance=distance,
            irregularity=line,
            settings={"track.irregularity.ramp_length": 0.0},  # the file begins with smooth track
        )
        force = run.normal_force.isel(wheelset=0)
        way = run.distance - run.distance[0]
        peak = force.mean("side").argmax("time")
        print(
            f"{name}: {float(force.min()) / 1e3:.2f} to {float(force.max()) / 1e3:.2f} kN, "
            f"largest at {float(way[peak]):.2f} m"
        )


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 40.0)

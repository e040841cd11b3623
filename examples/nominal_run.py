"""The nominal run: HD line at 300 km/h. Prints what each wheel carries, and draws it.

python examples/nominal_run.py [METRES]
"""

import sys

import rail_cosim


def main(distance: float) -> None:
    """Run ``distance`` metres; write nominal_run.nc and nominal_run.png."""
    run = rail_cosim.run(
        line="HD",
        speed=300,  # km/h
        distance=distance,
        out="nominal_run.nc",
        plot="nominal_run.png",
    )
    about = rail_cosim.summarise(run)
    print(f"evaluated: {about.range.text}")
    for wheelset in range(4):
        mean, sleepers = about.force_mean[wheelset, 0], about.force_sleeper[wheelset, 0]
        print(
            f"wheelset {wheelset + 1}: mean {mean / 1e3:.2f} kN, "
            f"at {about.sleeper_frequency:.1f} Hz +- {sleepers:.0f} N"
        )


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 100.0)

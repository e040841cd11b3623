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
    print(about)
    left = about.data.sel(side="left")
    for wheelset in left["wheelset"].to_numpy():
        one = left.sel(wheelset=wheelset)
        mean, passing = one["wheel_force_mean"], one["wheel_force_fastener_passing_amplitude"]
        print(
            f"wheelset {wheelset}: mean {float(mean) / 1e3:.2f} kN, "
            f"at {about.fastener_passing_frequency:.1f} Hz +- {float(passing):.0f} N"
        )


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 100.0)

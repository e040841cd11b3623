"""A rail joint in both rails, 12.58 m ahead: the largest wheel force and where it occurs.

python examples/rail_joint.py [METRES]
"""

import sys

import rail_cosim


def main(distance: float) -> None:
    """Run ``distance`` metres over a joint; print and draw the force of the leading wheel."""
    run = rail_cosim.run(
        line="HD",
        speed=300,
        distance=distance,
        irregularity="rail_joint",
        macro_step=5e-5,  # the impact lasts a millisecond
        settings={"track.integration.maximum_step": 2e-5},
        plot="rail_joint.png",
    )
    force = run.normal_force.sel(wheelset=1, side="left")
    at_rest = float(force[0])
    way = run.distance - run.distance[0]
    peak = force.argmax("time")
    print(f"at rest {at_rest / 1e3:.2f} kN")
    print(f"largest {float(force[peak]) / 1e3:.2f} kN at {float(way[peak]):.3f} m")
    print(f"smallest {float(force.min()) / 1e3:.2f} kN")
    print(f"dynamic factor {float(force[peak]) / at_rest:.3f}")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 20.0)

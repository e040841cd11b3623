"""A sweep: how the axle box shakes over speed and pad stiffness, as a data set and a picture.

python examples/sweep_pads.py [METRES]
"""

import sys

import rail_cosim


def main(distance: float) -> None:
    """Run all points, each until it is steady or ``distance`` metres."""
    data = rail_cosim.sweep(
        grid={
            "speed": [120, 170, 220, 270],  # km/h
            "track.fastener.vertical_stiffness": [40e6, 140e6],  # N/m
        },
        run={"line": "HD", "distance": distance},
        keep={"axle_box_vertical_acceleration": ["half_range"], "normal_force": ["max", "min"]},
        out="sweep_pads.nc",
        plot="sweep_pads.png",
    )
    box = data.axle_box_vertical_acceleration_half_range.max(["wheelset", "side"])
    for stiffness in box["track.fastener.vertical_stiffness"]:
        values = box.sel({"track.fastener.vertical_stiffness": stiffness})
        print(
            f"{float(stiffness) / 1e6:.0f} MN/m: largest {float(values.max()):.1f} m/s2 "
            f"at {int(values.idxmax('speed'))} km/h"
        )


if __name__ == "__main__":  # the workers are processes that read this file
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 200.0)

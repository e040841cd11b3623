"""Pads that stiffen in the cold: at 170 km/h the sleepers excite the wheelset on its track.

Frozen pads of 140 MN/m move the P2 resonance to the sleeper-passing frequency of that speed.

python examples/winter_pads.py [METRES]
"""

import sys

import rail_cosim

SPEED = 170  # km/h
PADS = {"summer": 40e6, "winter": 140e6}  # N/m


def main(distance: float) -> None:
    """Run ``distance`` metres with either pad; print amplitudes and their ratio."""
    amplitudes = {}
    for season, stiffness in PADS.items():
        run = rail_cosim.run(
            line="HD",
            speed=SPEED,
            distance=distance,
            settings={"track.fastener.vertical_stiffness": stiffness},
        )
        about = rail_cosim.summarise(run)
        amplitudes[season] = float(about["axle_box_acceleration_fastener_passing_amplitude"].max())
        force = float(about["wheel_force_fastener_passing_amplitude"].max())
        print(
            f"{season}: {stiffness / 1e6:.0f} MN/m, {about.fastener_passing_frequency:.1f} Hz, "
            f"axle box +- {amplitudes[season]:.2f} m/s2, "
            f"wheel force +- {force / 1e3:.2f} kN"
        )
    print(f"winter is {amplitudes['winter'] / amplitudes['summer']:.1f} times summer")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0)

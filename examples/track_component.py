"""The track by itself, without FMI and without a vehicle: how soft the rail head is.

Prints the static compliance over a fastener and between two, and the receptance up to
the first resonance of the rails on their pads.

python examples/track_component.py
"""

import dataclasses

import numpy as np
from slab_track import HD, TrackParameters
from slab_track.frequency import middle, receptance


def compliance(track: TrackParameters, frequency: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Deflection over a fastener and between two per force on both rails, m/N, shapes (f,)."""
    places = middle(track)
    found = receptance(track, frequency, np.array([places.fastener, places.mid_bay]))
    both = found.same_rail + found.other_rail
    return both[:, 0, 0], both[:, 1, 1]


def main() -> None:
    """Print static compliances, and where the rail head moves most."""
    for name, stiffness in (("summer", 40e6), ("winter", 140e6)):
        fastener = dataclasses.replace(HD.fastener, vertical_stiffness=stiffness)
        track = dataclasses.replace(HD, fastener=fastener)
        over, between = (float(c[0].real) for c in compliance(track, np.zeros(1)))
        print(f"{name}: {1e9 * over:.3f} nm/N over a fastener, {1e9 * between:.3f} between")
        frequency = np.arange(20.0, 400.0, 2.0)
        over, _ = compliance(track, frequency)
        print(f"{name}: softest at {frequency[np.abs(over).argmax()]:.0f} Hz")


if __name__ == "__main__":
    main()

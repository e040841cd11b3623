"""Random valid parameter sets for property tests, drawn from what each parameter says of itself.

New parameters join by themselves: a number is drawn around its default and within its own limits.
"""

import dataclasses
from collections.abc import Mapping
from typing import Any

from hypothesis import HealthCheck, reject, settings
from hypothesis import strategies as st
from rail_quantities import ParameterError, ParameterSet, Quantity, flatten, with_values
from slab_track import TrackParameters

SPREAD = 1.4
"""Largest factor between a drawn value and its default, either way."""

TRACK_RANGES: dict[str, Any] = {
    # Steel is steel; a wheelset fits its rails.
    "rail.youngs_modulus": (2.0e11, 2.12e11),
    "rail.shear_modulus": (7.7e10, 8.1e10),
    "rail.gauge": (1.432, 1.437),
    "rail.gauge_measurement_depth": (0.014, 0.016),
    "rail.cant": (0.024, 0.05),
    "contact.rolling_circle_distance": (1.490, 1.500),
    "contact.friction_coefficient": (0.1, 0.3, 0.5),
    "contact.reference_penetration": (5e-5, 1e-4),
    "slab.gap": (0.03, 0.12),
    "slab.damping_ratio": (0.0, 0.05),
    "slab_support.vertical_stiffness": (5e8, 2e10),
    "fastener.spacing": (0.55, 0.70),
    "fastener.vertical_stiffness": (1.5e7, 3e8),
    "fastener.count_per_slab": (6, 9),
    "integration.maximum_step": (5e-5, 2e-4),
    "static_wheel_load": (3e4, 1.2e5),
}
"""Lowest and highest value where the spread is not what an engineer would try; three: choices."""

CONTACT = (
    *(name for name in flatten(TrackParameters()) if name.startswith("contact.")),
    "rail.gauge",
    "rail.gauge_measurement_depth",
    "rail.cant",
    "rail.axis_depth",
    "rail.youngs_modulus",
    "rail.shear_modulus",
)
"""What the contact's tables are made of: a second for each new set of them."""


def examples(count: int) -> settings:
    """Return settings for so many examples, the same ones in every run."""
    return settings(
        max_examples=count,
        derandomize=True,
        database=None,
        deadline=None,
        suppress_health_check=list(HealthCheck),
    )


@st.composite
def parameter_sets(
    draw: st.DrawFn,
    defaults: ParameterSet,
    ranges: Mapping[str, Any] | None = None,
    keep: tuple[str, ...] = (),
) -> Any:
    """Draw a set like ``defaults``; names in ``keep`` stay as they are there."""
    values = {}
    for name, (about, default) in flatten(defaults).items():
        strategy = None if name in keep else _values(about, default, (ranges or {}).get(name))
        if strategy is not None:
            values[name] = draw(strategy, label=name)
    try:
        return with_values(defaults, values)
    except ParameterError:
        reject()


def _values(about: Quantity, default: Any, given: Any) -> st.SearchStrategy | None:
    """Return what a parameter may be, ``None`` for its default only."""
    if given is not None and len(given) > 2:
        return st.sampled_from(given)
    if isinstance(default, bool | str):
        return None
    low, high = given or _around(about, default)
    if low == high:
        return None
    if isinstance(default, int):
        return st.integers(int(low), int(high))
    return st.floats(low, high)


def _around(about: Quantity, default: float) -> tuple[float, float]:
    """Return the range around a default within its limits; a zero stays one."""
    low, high = sorted((default / SPREAD, default * SPREAD))
    if isinstance(default, int):
        return default, default
    for limit, inside in ((about.above, 1.001), (about.at_least, 1.0)):
        low = low if limit is None else max(low, limit * inside)
    for limit, inside in ((about.below, 0.999), (about.at_most, 1.0)):
        high = high if limit is None else min(high, limit * inside)
    return low, high


def mirrored(p: TrackParameters) -> TrackParameters:
    """Return the track whose irregularity is the mirror image of another's."""
    swap = {"left": "right", "right": "left"}
    line = p.irregularity
    lateral = -1.0 if line.cosine.direction == "lateral" else 1.0
    return dataclasses.replace(
        p,
        irregularity=line.replace(
            alignment_factor=-line.alignment_factor,
            cross_level_factor=-line.cross_level_factor,
            rail_joint=line.rail_joint.replace(
                side=swap.get(line.rail_joint.side, line.rail_joint.side)
            ),
            cosine=line.cosine.replace(
                side=swap.get(line.cosine.side, line.cosine.side),
                depth=lateral * line.cosine.depth,
            ),
        ),
    )

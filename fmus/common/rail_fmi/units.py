"""SI units as text, resolved to the integer base exponents that FMI 2.0 wants."""

import re
from collections.abc import Mapping
from functools import cache

from rail_fmi.errors import TableError

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")

_SYMBOLS: dict[str, dict[str, int]] = {
    **{base: {base: 1} for base in BASE_UNITS},
    "1": {},
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Hz": {"s": -1},
}

WITHOUT_BASE: Mapping[str, str] = {
    "m/N^(2/3)": "Hertz constant of eq. (1): kg^(-2/3).m^(1/3).s^(4/3), no integer exponents",
}
"""Units that FMI 2.0 cannot resolve: they are declared by name, without ``BaseUnit``."""

_QUANTITIES = {
    "m": "Length",
    "rad": "Angle",
    "s": "Time",
    "m/s": "Velocity",
    "rad/s": "AngularVelocity",
    "m/s2": "Acceleration",
    "rad/s2": "AngularAcceleration",
    "N": "Force",
    "N.m": "Moment",
    "kg": "Mass",
    "kg/m": "MassPerLength",
    "kg.m2": "MomentOfInertia",
    "kg/m3": "Density",
    "N/m": "Stiffness",
    "N/m2": "StiffnessPerLength",
    "N/m3": "StiffnessPerArea",
    "N.s/m": "Damping",
    "N.s/m2": "DampingPerLength",
    "N.s/m3": "DampingPerArea",
    "N.m/rad": "RotationalStiffness",
    "N.m.s/rad": "RotationalDamping",
    "N.m2": "BendingStiffness",
    "Pa": "Pressure",
    "m2": "Area",
    "m4": "SecondMomentOfArea",
    "m6": "WarpingConstant",
    "1/m": "Curvature",
    "Hz": "Frequency",
    "J": "Energy",
    "W": "Power",
    "m/N": "Compliance",
    "m/N^(2/3)": "HertzConstant",
    "1": "Dimensionless",
}

_FACTOR = re.compile(r"(1|[A-Za-z]+)(-?\d+)?")


def quantity_name(unit: str) -> str:
    """Return the name of the FMI type of a unit, such as ``Force`` for ``N``."""
    return _QUANTITIES.get(unit, f"Quantity in {unit}")


@cache
def _exponents(unit: str) -> tuple[tuple[str, int], ...]:
    head, slash, tail = unit.partition("/")
    total: dict[str, int] = dict.fromkeys(BASE_UNITS, 0)
    if tail.startswith("(") and tail.endswith(")"):
        tail = tail[1:-1]
    elif "." in tail:
        raise TableError(f"unit {unit!r}: write the divisor as /({tail})")
    for product, sign in ((head, 1), (tail, -1)) if slash else ((head, 1),):
        for factor in product.split("."):
            match = _FACTOR.fullmatch(factor)
            if match is None or match[1] not in _SYMBOLS:
                raise TableError(
                    f"unit {unit!r}: {factor!r} is not known; use SI units without prefixes, "
                    "such as N.s/m or kg.m2"
                )
            for base, power in _SYMBOLS[match[1]].items():
                total[base] += sign * power * int(match[2] or 1)
    return tuple((base, power) for base, power in total.items() if power)


def base_exponents(unit: str) -> dict[str, int] | None:
    """Return the non-zero exponents of the SI base units, in the order of the schema.

    Parameters
    ----------
    unit
        Products with ``.``, one ``/``, exponents as digits: ``"N.s/m"``,
        ``"kg.m2"``, ``"N/(m.rad)"``; ``"1"`` for none.

    Returns
    -------
    dict or None
        ``{"kg": 1, "m": 1, "s": -2}`` for ``"N"``; ``None`` for the units of
        :data:`WITHOUT_BASE`.

    Raises
    ------
    TableError
        For a text that is not a product of SI units.
    """
    return None if unit in WITHOUT_BASE else dict(_exponents(unit))

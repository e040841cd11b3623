"""Sizes that a quantity can have in this field, by unit: beyond them a value is a slip.

They are wide: some orders of magnitude past all that is built, with room for supports that stand
for rigid ones. What lies outside is a wrong
unit or a wrong exponent, and would only come back as overflow, or as a matrix of no rank.
"""

SIZES: dict[str, tuple[float, float]] = {
    "1": (1e-9, 1e9),
    "m": (1e-12, 1e12),
    "m2": (1e-8, 1e2),
    "m4": (1e-12, 1e2),
    "s": (1e-7, 1e3),
    "kg": (1e-2, 1e8),
    "kg/m3": (1e-1, 1e6),
    "kg.m2": (1e-3, 1e10),
    "m/s": (1e-6, 1e3),
    "m/s2": (1e-9, 1e4),
    "N": (1e-6, 1e9),
    "N/m": (1e-3, 1e18),
    "N/m3": (1e-3, 1e18),
    "N.s/m": (1e-3, 1e10),
    "N.m/rad": (1e-3, 1e13),
    "N.m2": (1e-3, 1e18),
    "m/N^(2/3)": (1e-12, 1e-3),
    "Pa": (1e3, 1e18),
}
"""Smallest and largest size of a value that is not zero."""


def misfit(value: float, unit: str) -> str:
    """Return the sizes a value of this unit can have if it has none of them, else nothing."""
    low, high = SIZES.get(unit, (0.0, float("inf")))
    if value == 0.0 or low <= abs(value) <= high:
        return ""
    shown = "" if unit == "1" else f" {unit}"
    return f"must be of a size from {low:g} to {high:g}{shown}"

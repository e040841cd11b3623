"""One physical quantity: what it is, its unit, and the values it may take."""

import dataclasses
import math
from typing import Any

from rail_quantities.errors import ParameterError
from rail_quantities.ranges import misfit

_KEY = "quantity"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Quantity:
    """Description of one parameter.

    Attributes
    ----------
    unit
        SI unit as FMI writes it (``"N/m"``, ``"kg.m2"``); ``"1"`` for none.
    description
        Meaning in one sentence.
    symbol
        The symbol of the theory manual and the article, as plain text.
    above, at_least, below, at_most
        Open and closed limits; ``None`` for none.
    choices
        The allowed words of a text parameter; empty for free text.
    nominal
        A typical magnitude, for tools that scale; ``None`` for none.
    source
        Where the default value comes from.
    """

    unit: str = "1"
    description: str = ""
    symbol: str = ""
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    choices: tuple[str, ...] = ()
    nominal: float | None = None
    source: str = ""

    @property
    def limits(self) -> str:
        """The allowed range in words, empty if there is none."""
        pairs = (
            ("greater than", self.above),
            ("at least", self.at_least),
            ("less than", self.below),
            ("at most", self.at_most),
        )
        return " and ".join(f"{word} {limit:g}" for word, limit in pairs if limit is not None)

    def check(self, name: str, value: Any, kind: type) -> Any:
        """Return ``value`` as ``kind`` or raise :class:`ParameterError`.

        ``kind`` is the type of the parameter's default: float, int, bool or str.
        """
        if kind is str:
            return self._check_text(name, value)
        if kind is bool:
            if not isinstance(value, bool):
                raise ParameterError(name, value, "must be true or false")
            return value
        return self._check_number(name, value, kind)

    def _check_text(self, name: str, value: Any) -> str:
        if not isinstance(value, str):
            raise ParameterError(name, value, "must be text")
        if self.choices and value not in self.choices:
            raise ParameterError(name, value, "must be one of " + ", ".join(self.choices))
        return value

    def _check_number(self, name: str, value: Any, kind: type) -> float | int:
        try:
            number = float(value)
        except (TypeError, ValueError, OverflowError):
            number = math.nan
        if isinstance(value, bool | str) or not math.isfinite(number):
            raise ParameterError(name, value, "must be a finite number", self._remedy())
        if kind is int and number != int(number):
            raise ParameterError(name, value, "must be a whole number", self._remedy())
        broken = (
            (self.above is not None and not number > self.above)
            or (self.at_least is not None and not number >= self.at_least)
            or (self.below is not None and not number < self.below)
            or (self.at_most is not None and not number <= self.at_most)
        )
        if broken:
            unit = "" if self.unit == "1" else f" {self.unit}"
            raise ParameterError(name, value, f"must be {self.limits}{unit}", self._remedy())
        if kind is float and (limit := misfit(number, self.unit)):
            raise ParameterError(name, value, limit, self._remedy())
        return kind(number)

    def _remedy(self) -> str:
        return f"meaning: {self.description}".rstrip(".") if self.description else ""


def quantity(default: Any, unit: str = "1", description: str = "", **more: Any) -> Any:
    """Make a dataclass field with a :class:`Quantity` in its metadata."""
    about = Quantity(unit=unit, description=description, **more)
    return dataclasses.field(default=default, metadata={_KEY: about})


def quantity_of(field: dataclasses.Field[Any]) -> Quantity | None:
    """Return the description of a dataclass field, ``None`` if it has none."""
    return field.metadata.get(_KEY)

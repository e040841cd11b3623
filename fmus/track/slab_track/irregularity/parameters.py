"""Parameters of the track irregularities, ``irregularity.*`` of the FMU.

The random part, the rail joint, the cosine and the user's file are independent
of each other and add up; each is off by default.
"""

import dataclasses
from typing import ClassVar

from rail_quantities import ParameterError, ParameterSet, quantity

from slab_track.irregularity.spectra import SPECTRA, Spectrum

SIDES = ("none", "both", "left", "right")
DIRECTIONS = ("vertical", "lateral")
_REPEAT = "distance after which it comes again, endlessly in running direction; 0 for once"
_SHORTEST = 0.01
_LONGEST = 1000.0
_SMALLEST_RATIO = 1.5


def _check_repeat(group: str, repeat: float, length: float) -> None:
    if 0 < repeat < length:
        raise ParameterError(
            f"{group}.repeat_distance",
            repeat,
            f"must be 0 or at least the length {length:g} m",
            "overlapping cosines are not supported",
        )


@dataclasses.dataclass(frozen=True, kw_only=True)
class RailJointParameters(ParameterSet):
    """Rail joint of Fig. 6: a long and a short cosine dip with the same centre."""

    GROUP: ClassVar[str] = "irregularity.rail_joint"

    side: str = quantity("none", description="rail that has the joint", choices=SIDES)
    position: float = quantity(
        12.58,
        "m",
        "centre of the (first) joint along the line; at mid-span between two fasteners at whole "
        "multiples of fastener.spacing",
    )
    repeat_distance: float = quantity(0.0, "m", _REPEAT, at_least=0)
    long_wavelength: float = quantity(
        1.0, "m", "length of the long dip", symbol="lambda_1", above=0, source="article, 2.4"
    )
    long_depth: float = quantity(
        0.3e-3,
        "m",
        "depth of the long dip, down positive",
        symbol="delta_1",
        nominal=1e-3,
        source="article, 2.4",
    )
    short_wavelength: float = quantity(
        0.1, "m", "length of the short dip", symbol="lambda_2", above=0, source="article, 2.4"
    )
    short_depth: float = quantity(
        0.3e-3,
        "m",
        "depth of the short dip, down positive",
        symbol="delta_2",
        nominal=1e-3,
        source="article, 2.4",
    )

    def check(self) -> None:
        """Refuse joints that overlap."""
        longest = max(self.long_wavelength, self.short_wavelength)
        _check_repeat(self.GROUP, self.repeat_distance, longest)


@dataclasses.dataclass(frozen=True, kw_only=True)
class CosineParameters(ParameterSet):
    """A dip (depth positive) or bump (negative) of one cosine wave."""

    GROUP: ClassVar[str] = "irregularity.cosine"

    side: str = quantity("none", description="rail that has the cosine", choices=SIDES)
    direction: str = quantity(
        "vertical", description="vertical (down positive) or lateral (right)", choices=DIRECTIONS
    )
    position: float = quantity(20.0, "m", "centre of the (first) cosine along the line")
    length: float = quantity(1.0, "m", "length from edge to edge", symbol="lambda", above=0)
    depth: float = quantity(
        1e-3, "m", "depth of a dip, negative for a bump", symbol="delta", nominal=1e-3
    )
    repeat_distance: float = quantity(0.0, "m", _REPEAT, at_least=0)

    def check(self) -> None:
        """Refuse cosines that overlap."""
        _check_repeat(self.GROUP, self.repeat_distance, self.length)


@dataclasses.dataclass(frozen=True, kw_only=True)
class FileParameters(ParameterSet):
    """A measured irregularity by distance, from a CSV or NetCDF file."""

    GROUP: ClassVar[str] = "irregularity.file"

    path: str = quantity("", description="CSV or NetCDF file by distance; empty for none")
    position: float = quantity(0.0, "m", "position along the line of the file's distance 0")
    fade_length: float = quantity(
        20.0,
        "m",
        "length over which it fades to zero before the first and after the last row of the file",
        above=0,
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class IrregularityParameters(ParameterSet):
    """All irregularities of the line."""

    GROUP: ClassVar[str] = "irregularity"

    spectrum: str = quantity(
        "none", description="spectrum of the random part", choices=("none", *SPECTRA)
    )
    seed: int = quantity(
        1,
        description="number that selects the track irregularity realisation",
        at_least=0,
        at_most=2147483647,
    )
    shortest_wavelength: float = quantity(
        0.0, "m", "shortest wavelength of the random part; 0 for the spectrum's own", at_least=0
    )
    longest_wavelength: float = quantity(
        0.0, "m", "longest wavelength of the random part; 0 for the spectrum's own", at_least=0
    )
    level_factor: float = quantity(1.0, "1", "factor on the random vertical profile")
    alignment_factor: float = quantity(1.0, "1", "factor on the random alignment")
    cross_level_factor: float = quantity(1.0, "1", "factor on the random cross-level")
    gauge_factor: float = quantity(1.0, "1", "factor on the random gauge deviation")
    start: float = quantity(
        0.0, "m", "position before which there is neither random part nor file: smooth track"
    )
    ramp_length: float = quantity(
        20.0,
        "m",
        "length after `start` over which random part and file fade in; 0: no fade-in, both are "
        "there on the whole line, before `start` too",
        at_least=0,
    )
    rail_joint: RailJointParameters = RailJointParameters()
    cosine: CosineParameters = CosineParameters()
    file: FileParameters = FileParameters()

    def check(self) -> None:
        """Refuse an empty or extreme wavelength band."""
        if self.spectrum == "none":
            return
        shortest, longest = self.band
        name = f"{self.GROUP}.shortest_wavelength"
        if shortest < _SHORTEST:
            raise ParameterError(name, shortest, f"must be 0 or at least {_SHORTEST} m")
        if not longest >= _SMALLEST_RATIO * shortest:
            raise ParameterError(
                name,
                shortest,
                f"must be at most the longest wavelength ({longest:g} m) / {_SMALLEST_RATIO:g}",
                "set irregularity.longest_wavelength too",
            )
        if longest > _LONGEST:
            name = f"{self.GROUP}.longest_wavelength"
            raise ParameterError(name, longest, f"must be at most {_LONGEST:g} m")

    @property
    def spectrum_function(self) -> Spectrum | None:
        """The spectrum, ``None`` without a random part."""
        return None if self.spectrum == "none" else SPECTRA[self.spectrum]

    @property
    def band(self) -> tuple[float, float]:
        """Shortest and longest wavelength of the random part, m (0, 0 without one)."""
        spectrum = self.spectrum_function
        if spectrum is None:
            return 0.0, 0.0
        shortest, longest = spectrum.band
        return self.shortest_wavelength or shortest, self.longest_wavelength or longest

    @property
    def factors(self) -> tuple[float, float, float, float]:
        """Factors on level, alignment, cross-level and gauge."""
        return (
            self.level_factor,
            self.alignment_factor,
            self.cross_level_factor,
            self.gauge_factor,
        )

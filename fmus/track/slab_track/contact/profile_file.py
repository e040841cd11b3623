"""Measured profiles from a file: two columns, checked, with controlled smoothing.

The file is text: lateral coordinate and height, separated by blanks, tabs,
semicolons or commas; lines starting with ``#`` or ``!`` are comments. Units are
millimetres; a comment ``# unit: m`` makes them metres. Orientation and signs
are those of :mod:`slab_track.contact.profiles` (flange and gauge side at
negative ``y``, ``z`` down).
"""

import dataclasses
import re
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from rail_quantities import ParameterError
from scipy.interpolate import BSpline, make_interp_spline, make_splrep

from slab_track.contact.builtin_profiles import RAILS, WHEELS, builtin_profile
from slab_track.contact.profiles import FloatArray, Profile

MINIMUM_POINTS = 20
MAXIMUM_SPACING = 0.005
_UNIT = re.compile(r"^[#!]\s*unit\s*[:=]\s*(\S+)", re.IGNORECASE)
_REQUIRED = {"wheel": (-0.045, 0.030), "rail": (-0.036, 0.020)}


@dataclasses.dataclass(frozen=True, kw_only=True)
class SplineProfile:
    """Measured profile as a cubic spline (twice continuously differentiable)."""

    name: str
    spline: BSpline
    start: float
    end: float

    def derivative(self, y: ArrayLike, order: int = 0) -> FloatArray:
        """Return height (order 0), slope (1) or second derivative (2); NaN outside."""
        lateral = np.asarray(y, dtype=float)
        inside = (lateral >= self.start) & (lateral <= self.end)
        values = self.spline(np.clip(lateral, self.start, self.end), nu=order)
        return np.where(inside, values, np.nan)


def load_profile(kind: str, source: str, noise: float = 0.0) -> Profile:
    """Return the built-in profile of a name, or the one in a file.

    Parameters
    ----------
    kind
        ``"wheel"`` or ``"rail"``.
    source
        Name of a built-in profile, or path of a file.
    noise
        Standard deviation of the measured heights (m), for files only: the
        spline leaves residuals of that size; 0 goes through every point.

    Raises
    ------
    ParameterError
        If the name is unknown or the file cannot be used; the message says why.
    """
    known = WHEELS if kind == "wheel" else RAILS
    if source in known or not _is_file(source):
        return builtin_profile(kind, source)
    points = _read_points(kind, Path(source))
    return profile_from_points(kind, points, name=Path(source).name, noise=noise)


def profile_from_points(
    kind: str, points: FloatArray, *, name: str, noise: float = 0.0
) -> SplineProfile:
    """Return a spline through measured points, shifted to the profile's own origin.

    Parameters
    ----------
    kind
        ``"wheel"``: heights count from the rolling circle at ``y = 0``;
        ``"rail"``: from the highest point of the head.
    points
        Lateral coordinate and height (m), shape (n, 2), in either order of ``y``.
    name
        Name for messages.
    noise
        Standard deviation of the heights (m); 0 interpolates.
    """
    _check_number(kind, points, name)
    ordered = points if points[-1, 0] > points[0, 0] else points[::-1]
    _check_points(kind, ordered, name)
    y, z = ordered[:, 0], ordered[:, 1]
    spline = _smooth(kind, y, z, noise, name) if noise > 0.0 else make_interp_spline(y, z, k=3)
    datum = float(spline(0.0)) if kind == "wheel" else float(np.min(spline(_fine(y))))
    shifted = BSpline(spline.t, spline.c - datum, spline.k)
    return SplineProfile(name=name, spline=shifted, start=float(y[0]), end=float(y[-1]))


def _is_file(source: str) -> bool:
    try:
        return Path(source).is_file()
    except (OSError, ValueError):  # no name that a file can have
        return False


def _smooth(kind: str, y: FloatArray, z: FloatArray, noise: float, name: str) -> BSpline:
    """Return the smoothest spline that leaves residuals of the size of the noise."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            return make_splrep(
                np.ascontiguousarray(y),  # scipy 1.15 demands it
                np.ascontiguousarray(z),
                w=np.full(y.size, 1.0 / noise),
                k=3,
                s=y.size,
            )
    except RuntimeWarning as error:
        raise _refused(
            kind,
            name,
            f"no smoothing spline leaves residuals of contact.profile_noise = {noise:g} m",
            "remove outliers, or give the standard deviation that its heights have",
        ) from error


def _fine(y: FloatArray) -> FloatArray:
    return np.linspace(y[0], y[-1], 20 * y.size)


def _read_points(kind: str, path: Path) -> FloatArray:
    scale, rows = 1e-3, []
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        reason = f"it cannot be read ({error.strerror or error})"
        raise _refused(kind, path.name, reason, "check its permissions") from error
    for number, line in enumerate(text.splitlines(), start=1):
        content = line.strip()
        unit = _UNIT.match(content)
        if unit:
            scale = _scale_of(kind, path, unit.group(1))
        if not content or content[0] in "#!":
            continue
        rows.append(_row(kind, path, number, content))
    return scale * np.array(rows, dtype=float).reshape(-1, 2)


def _scale_of(kind: str, path: Path, unit: str) -> float:
    scales = {"mm": 1e-3, "m": 1.0}
    if unit not in scales:
        raise _refused(
            kind, path.name, f"its unit is {unit[:60]!r}", "write '# unit: mm' or '# unit: m'"
        )
    return scales[unit]


def _row(kind: str, path: Path, number: int, content: str) -> list[float]:
    try:
        values = [float(field) for field in re.split(r"[;,\s]+", content) if field]
    except ValueError:
        values = []
    if len(values) != 2:
        raise _refused(
            kind,
            path.name,
            f"line {number} is {content[:60]!r}",
            "give two numbers a line, lateral coordinate and height, with decimal points",
        )
    return values


def _check_number(kind: str, points: FloatArray, name: str) -> None:
    if len(points) < MINIMUM_POINTS:
        raise _refused(
            kind,
            name,
            f"it has {len(points)} points",
            f"give at least {MINIMUM_POINTS}, closer where the profile is sharply curved",
        )


def _check_points(kind: str, points: FloatArray, name: str) -> None:
    if not np.all(np.isfinite(points)):
        raise _refused(kind, name, "a value is not a finite number", "remove such points")
    y = points[:, 0]
    steps = np.diff(y)
    if np.any(steps <= 0.0):
        row = int(np.argmax(steps <= 0.0))
        raise _refused(
            kind,
            name,
            f"the lateral coordinate turns back at {1e3 * y[row + 1]:g} mm",
            "sort the points and cut overhanging parts (flange back, rail web)",
        )
    low, high = _REQUIRED[kind]
    if y[0] > low or y[-1] < high or y[-1] - y[0] > 0.5:
        raise _refused(
            kind,
            name,
            f"it reaches from {1e3 * y[0]:g} to {1e3 * y[-1]:g} mm",
            f"it must cover {1e3 * low:g} to {1e3 * high:g} mm: check the unit (millimetres, or "
            "'# unit: m'), the origin, and that the flange or gauge side is at negative y",
        )
    _check_shape(kind, points, name, steps)


def _check_shape(kind: str, points: FloatArray, name: str, steps: FloatArray) -> None:
    y, z = points.T
    if np.max(steps) > MAXIMUM_SPACING:
        row = int(np.argmax(steps))
        raise _refused(
            kind,
            name,
            f"there is no point between {1e3 * y[row]:g} and {1e3 * y[row + 1]:g} mm",
            f"points must be at most {1e3 * MAXIMUM_SPACING:g} mm apart",
        )
    # Flange and gauge corner lie below the running surface: z is positive there.
    inner = float(np.interp(_REQUIRED[kind][0], y, z) - np.interp(0.0, y, z))
    if inner <= 0.002:
        raise _refused(
            kind,
            name,
            f"at {1e3 * _REQUIRED[kind][0]:g} mm it lies {1e3 * inner:g} mm below y = 0",
            "z counts down and the flange or gauge corner is at negative y: change signs",
        )


def _refused(kind: str, name: str, reason: str, remedy: str) -> ParameterError:
    return ParameterError(f"contact.{kind}_profile", name, reason, remedy)

"""What a user should be told about an irregularity, one sentence each."""

import numpy as np

from slab_track.irregularity.parameters import IrregularityParameters
from slab_track.irregularity.spectra import FloatArray

_LARGE, _LEFT = 0.95, 0.9
"""Excursion or slope in the ramp, as a part of the file's largest, that is remarked, and how much
of it must be left to pass without."""
_HEIGHT, _SLOPE = 1e-5, 1e-5
"""Irregularity under a wheel at the start (m) and its slope (m/m), that need no remark: the
wheelsets' static heights differ as much between the fasteners; 1e-5 at 300 km/h is 0.8 mm/s."""
_DIRECTIONS = ("vertical", "lateral")


def fade_in(parameters: IrregularityParameters) -> str:
    """Return where random part and file grow to full size; empty if they do not."""
    parts = [
        name
        for name, there in (
            ("the random part", parameters.spectrum != "none"),
            ("the file", parameters.file.path),
        )
        if there
    ]
    if not parts or parameters.ramp_length == 0.0:
        return ""
    start, length = parameters.start, parameters.ramp_length
    return (
        f"Fade-in of {' and '.join(parts)} of the irregularity: from {start:g} m to full size at "
        f"{start + length:g} m (irregularity.start, irregularity.ramp_length)."
    )


def parameter_remarks(parameters: IrregularityParameters) -> list[str]:
    """Return what is unusual about the parameters alone."""
    found = []
    spectrum = parameters.spectrum_function
    if spectrum is not None:
        shortest, longest = parameters.band
        if shortest < spectrum.valid[0] or longest > spectrum.valid[1]:
            found.append(
                f"The spectrum {spectrum.name} is given for wavelengths of "
                f"{spectrum.valid[0]:g} to {spectrum.valid[1]:g} m; "
                f"{shortest:g} to {longest:g} m extrapolate it."
            )
    faded = spectrum is not None or parameters.file.path
    if faded and parameters.ramp_length == 0.0 and parameters.start != 0.0:
        found.append(
            f"irregularity.start = {parameters.start:g} m has no effect with "
            "irregularity.ramp_length = 0: random part and file are there on the whole line."
        )
    return found


def file_remarks(
    parameters: IrregularityParameters, distance: FloatArray, values: FloatArray
) -> list[str]:
    """Return what start and ramp take away from a file.

    Parameters
    ----------
    parameters
        Of the irregularity.
    distance
        Rows of the file along the line, shape (n,), m.
    values
        Value (m) and slope (m/m) of the rails there, shape (n, 4, 2), flattened (side, direction).
    """
    if parameters.ramp_length == 0.0:
        return []
    found = []
    if distance[0] < parameters.start:
        found.append(
            f"The irregularity file begins at {distance[0]:g} m, before irregularity.start = "
            f"{parameters.start:g} m: it is left out up to there."
        )
    excursion = values[..., 0] - np.median(values[..., 0], axis=0)
    lost = _lost(parameters, distance, excursion)
    if lost is not None:
        return [*found, _faded(parameters, "excursion", "mm", *lost)]
    lost = _lost(parameters, distance, values[..., 1])
    return found if lost is None else [*found, _faded(parameters, "slope", "mm/m", *lost)]


def _lost(
    parameters: IrregularityParameters, distance: FloatArray, values: FloatArray
) -> tuple[str, float, float, float] | None:
    """Return direction, size, position and what is left of the largest value that is faded."""
    t = (distance - parameters.start) / parameters.ramp_length
    ramp = np.where((t >= 0.0) & (t < 1.0), t**3 * (10.0 + t * (6.0 * t - 15.0)), 1.0)
    for index, direction in enumerate(_DIRECTIONS):
        size = np.abs(values[:, index::2]).max(axis=1)
        reduced = (size > _LARGE * size.max()) & (ramp < _LEFT)
        if reduced.any():
            row = int(np.argmax(np.where(reduced, size, 0.0)))
            return direction, float(size[row]), float(distance[row]), float(ramp[row])
    return None


def _faded(
    parameters: IrregularityParameters,
    what: str,
    unit: str,
    direction: str,
    size: float,
    position: float,
    rest: float,
) -> str:
    start, length = parameters.start, parameters.ramp_length
    return (
        f"The {direction} {what} of {1e3 * size:.3g} {unit} at {position:g} m in the irregularity "
        f"file lies in the ramp from {start:g} to {start + length:g} m (irregularity.start, "
        f"irregularity.ramp_length): {100 * rest:.3g} % of it is left. If the file begins with "
        "smooth track under the vehicle, set irregularity.ramp_length = 0; else move the file "
        "ahead with irregularity.file.position."
    )


def start_remarks(
    parameters: IrregularityParameters,
    positions: FloatArray,
    offsets: FloatArray,
    slopes: FloatArray,
) -> list[str]:
    """Return what is unusual about the wheelsets' positions at the start.

    Parameters
    ----------
    parameters
        Of the irregularity.
    positions
        Of the wheelsets, shape (n,), m.
    offsets, slopes
        The irregularity there (m, m/m), shape (n, 2, 2).
    """
    found = []
    height, slope = float(np.abs(offsets).max()), float(np.abs(slopes).max())
    if height > _HEIGHT or slope > _SLOPE:
        found.append(
            f"The run starts on the irregularity: up to {1e3 * height:.3g} mm under the wheels, "
            f"slope up to {1e3 * slope:.3g} mm/m. The wheelsets start at rest on it, so forces and "
            "accelerations begin with a transient; lead in with smooth track, or do not evaluate "
            "the first slab lengths."
        )
    last = float(positions.min())
    joint, cosine = parameters.rail_joint, parameters.cosine
    longest = max(joint.long_wavelength, joint.short_wavelength)
    for group, length in ((joint, longest), (cosine, cosine.length)):
        passed = group.position + 0.5 * length < last
        if group.side != "none" and group.repeat_distance == 0.0 and passed:
            found.append(
                f"{group.GROUP}.position = {group.position:g} m is behind the last wheelset, which "
                f"starts at {last:g} m: no wheel passes it."
            )
    return found

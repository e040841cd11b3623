"""The irregularity of an endless line, made from its parameters."""

import numpy as np
from numpy.typing import ArrayLike

from slab_track.irregularity.bands import Band, design_bands
from slab_track.irregularity.files import read_file
from slab_track.irregularity.kernels import (
    BLOCK,
    EMPTY,
    FARTHEST,
    STORED,
    IrregularityData,
    evaluate_into,
)
from slab_track.irregularity.parameters import IrregularityParameters
from slab_track.irregularity.remarks import (
    fade_in,
    file_remarks,
    parameter_remarks,
    start_remarks,
)
from slab_track.irregularity.spectra import FloatArray
from slab_track.irregularity.table import knots_of_columns

_KEPT_LENGTH = 64.0
"""Length (m) of line that the kept samples cover, so that all wheels of a vehicle share them."""
_WEIGHTS = {"left": (1.0, 0.0), "right": (0.0, 1.0), "both": (1.0, 1.0)}


class Irregularity:
    """Irregularity of the two rails at any place of an endless line.

    A pure function of the place and the parameters: it has no state to save, comes
    out bit-equal in any order of evaluation, never repeats, and has a continuous
    slope everywhere.

    Parameters
    ----------
    parameters
        See :class:`IrregularityParameters`.

    Attributes
    ----------
    parameters
        As given.
    data
        What :func:`slab_track.irregularity.evaluate_into` takes inside compiled
        loops.
    fade_in
        Where random part and file grow to full size, in a sentence; empty without a ramp.
    remarks
        What a user should be warned of with these parameters, one sentence each.

    Raises
    ------
    IrregularityFileError
        If the user's file cannot be used.

    Examples
    --------
    >>> parameters = IrregularityParameters(spectrum="german_low", seed=7)
    >>> offsets, slopes = Irregularity(parameters).evaluate([1000.0, 1002.5])
    >>> offsets.shape  # [place, side, direction]
    (2, 2, 2)
    """

    def __init__(self, parameters: IrregularityParameters) -> None:
        self.parameters = parameters
        spectrum = parameters.spectrum_function
        bands: list[Band] = []
        if spectrum is not None and any(parameters.factors):
            bands = design_bands(spectrum, *parameters.band, parameters.factors)
        knots, knot_values = np.zeros(0), np.zeros((0, 4, 2))
        remarks = parameter_remarks(parameters)
        if parameters.file.path:
            file = parameters.file
            columns = read_file(file.path)
            knots, knot_values = knots_of_columns(columns, file.position, file.fade_length)
            rows = np.isin(knots, columns["distance"] + file.position)
            remarks += file_remarks(parameters, knots[rows], knot_values[rows])
        # Without a ramp nothing is cut off anywhere, so that no value jumps.
        ramped = parameters.ramp_length > 0.0
        layout = _layout(bands)
        slots = int(layout[:, 1].sum())
        self.data = IrregularityData(
            seed=parameters.seed,
            start=parameters.start if ramped else -np.inf,
            ramp_length=parameters.ramp_length if ramped else 1.0,
            inverse_spacing=np.array([1 / band.spacing for band in bands]),
            layout=layout,
            filters=np.concatenate([band.kernels for band in bands] or [np.zeros((4, 0))], axis=1),
            kept_blocks=np.full(slots, EMPTY),
            kept_samples=np.zeros((slots, STORED, 4)),
            noise=np.zeros(STORED + int(layout[:, 3].max(initial=1)) - 1),
            cosines=_cosines(parameters),
            knots=knots,
            knot_values=knot_values,
        )
        self.fade_in = fade_in(parameters)
        self.remarks = tuple(remarks)

    def evaluate(self, x: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return offsets (m) and slopes d/dx (m/m) at the places ``x`` (n,), both (n, 2, 2).

        The axes are place, side (left, right) and direction (vertical: down positive,
        lateral: right positive). A wheel rolling at speed v sees the velocity
        ``v * slope``.

        Raises
        ------
        ValueError
            If a place is not a number or farther than 1e12 m.
        """
        places = np.ascontiguousarray(x, dtype=float)
        if places.ndim != 1:
            raise ValueError(f"x has the shape {places.shape}: give one place per row, shape (n,)")
        if not np.all(np.abs(places) <= FARTHEST):
            worst = places[~(np.abs(places) <= FARTHEST)][0]
            raise ValueError(f"x = {worst!r} m: must be a number between -1e12 and 1e12")
        offsets = np.empty((places.size, 2, 2))
        slopes = np.empty_like(offsets)
        evaluate_into(places, self.data, offsets, slopes)
        return offsets, slopes

    def start_remarks(self, positions: FloatArray) -> tuple[str, ...]:
        """Return what a user should be told of a start with wheelsets at ``positions`` (n,), m."""
        return tuple(start_remarks(self.parameters, positions, *self.evaluate(positions)))


def _layout(bands: list[Band]) -> np.ndarray:
    """Return first slot, slot count, first tap and tap count of each band."""
    rows = np.zeros((len(bands), 4), dtype=np.int64)
    slot = tap = 0
    for row, band in zip(rows, bands, strict=True):
        blocks = _KEPT_LENGTH / (band.spacing * BLOCK) + 1
        slots, taps = 1 << int(np.ceil(np.log2(blocks))), band.kernels.shape[1]
        row[:] = slot, slots, tap, taps
        slot, tap = slot + slots, tap + taps
    return rows


def _cosines(parameters: IrregularityParameters) -> FloatArray:
    """Return the rows of :attr:`IrregularityData.cosines`."""
    rows = []
    joint, cosine = parameters.rail_joint, parameters.cosine
    if joint.side != "none":
        left, right = _WEIGHTS[joint.side]
        for length, depth in (
            (joint.long_wavelength, joint.long_depth),
            (joint.short_wavelength, joint.short_depth),
        ):
            rows.append((joint.position, length, depth, joint.repeat_distance, left, 0, right, 0))
    if cosine.side != "none":
        left, right = _WEIGHTS[cosine.side]
        vertical = cosine.direction == "vertical"
        weights = (left, 0, right, 0) if vertical else (0, left, 0, right)
        wave = (cosine.position, cosine.length, cosine.depth, cosine.repeat_distance)
        rows.append((*wave, *weights))
    return np.array(rows, dtype=float).reshape(-1, 8)

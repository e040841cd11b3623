r"""Receptance of the rail heads: displacement per unit harmonic force, anywhere in a window.

From the matrices of the time domain, so that both views describe one track. The two symmetry
classes (:mod:`slab_track.assembly`) combine to

.. math:: \alpha_{same} = \tfrac12(\alpha_s + \alpha_a),\quad
          \alpha_{other} = \tfrac12(\alpha_s - \alpha_a)

for a force on one rail. Laterally and in roll each rail is alone. A lateral force at the head,
:math:`h_h` above the axis, is a force and a moment on the axis; with
:math:`H = ((1, h_h), (0, 1))` the head has :math:`H \alpha H^T`.
"""

from typing import NamedTuple, Self

import numpy as np
from rail_quantities import ParameterError

from slab_track.assembly import ANTISYMMETRIC, SYMMETRIC, assemble
from slab_track.frequency.lateral import LateralResponse
from slab_track.frequency.vertical import VerticalResponse
from slab_track.lateral import assemble_lateral
from slab_track.parameters import TrackParameters


class Receptance(NamedTuple):
    """Motion of the rail heads per unit harmonic load, complex (time factor exp(i omega t)).

    Attributes
    ----------
    frequency
        Hz, shape (f,).
    same_rail, other_rail
        Vertical deflection of the loaded and of the other rail per vertical force, m/N,
        shape (f, receivers, sources).
    lateral
        Lateral displacement of the head and roll of the loaded rail (second-last axis) per
        lateral force at the head and roll moment (last axis): m/N, m/(N.m), rad/N,
        rad/(N.m), shape (f, receivers, sources, 2, 2). The other rail does not move.
    """

    frequency: np.ndarray
    same_rail: np.ndarray
    other_rail: np.ndarray
    lateral: np.ndarray

    def mobility(self) -> Self:
        """Return velocity per unit load: i omega times the receptance."""
        return self._differentiated(1)

    def accelerance(self) -> Self:
        """Return acceleration per unit load: -omega^2 times the receptance."""
        return self._differentiated(2)

    def _differentiated(self, order: int) -> Self:
        factor = (2j * np.pi * self.frequency) ** order
        return self._replace(
            same_rail=self.same_rail * factor[:, None, None],
            other_rail=self.other_rail * factor[:, None, None],
            lateral=self.lateral * factor[:, None, None, None, None],
        )


class Middle(NamedTuple):
    """Places nearest to the middle of the window, far from its hinges; m from its start.

    Attributes
    ----------
    mid_bay, fastener
        Half-way between two fasteners, and over the one behind it, m.
    """

    mid_bay: float
    fastener: float


def middle(p: TrackParameters) -> Middle:
    """Return a place half-way between two fasteners, and one over the fastener behind it.

    Both belong to the slab in the middle of the window; with an odd number of slabs and
    an even number of fasteners ``mid_bay`` is the middle of that slab.
    """
    first = p.window.slab_count // 2 * p.fastener.count_per_slab
    bays = first + p.fastener.count_per_slab // 2
    return Middle(bays * p.fastener.spacing, (bays + 0.5) * p.fastener.spacing)


def receptance(
    p: TrackParameters,
    frequency: np.ndarray,
    sources: np.ndarray,
    receivers: np.ndarray | None = None,
) -> Receptance:
    """Return the receptance of the rail heads.

    Parameters
    ----------
    p
        Parameters of the track. With ``rail.motion = "vertical"`` the rails are held
        laterally and in roll, and :attr:`Receptance.lateral` is zero.
    frequency
        Hz, shape (f,); 0 gives the static compliance (not on a ring, whose rails only rest on
        fasteners: there a frequency above 0).
    sources, receivers
        Places of loads and motions, m from the window's start; without ``receivers`` the
        motion is taken at the sources. The hinges at the window's ends reflect: keep away
        from them (:func:`middle`), the more so the lighter the damping.

    Raises
    ------
    ParameterError
        For a place outside the window or a frequency that is negative or not finite.
    """
    frequency = np.atleast_1d(np.asarray(frequency, dtype=float))
    sources = np.atleast_1d(np.asarray(sources, dtype=float))
    receivers = sources if receivers is None else np.atleast_1d(np.asarray(receivers, dtype=float))
    bad = ~(np.isfinite(frequency) & (frequency >= 0.0))
    if bad.any():
        raise ParameterError(
            "frequency", float(frequency[bad][0]), "must be finite and at least 0 Hz"
        )
    if p.ring and not np.all(frequency > 0.0):
        raise ParameterError(
            "frequency",
            0.0,
            "must be above 0 Hz with window.method = cyclic",
            "give a small frequency, or take window.method = sliding",
        )
    vertical = VerticalResponse(assemble(p), sources, receivers)
    shape = (frequency.size, receivers.size, sources.size)
    same, other = np.empty(shape, dtype=complex), np.empty(shape, dtype=complex)
    for i, f in enumerate(frequency):
        s = 2j * np.pi * f
        symmetric = vertical.solve(s, SYMMETRIC).rail
        antisymmetric = vertical.solve(s, ANTISYMMETRIC).rail
        same[i], other[i] = 0.5 * (symmetric + antisymmetric), 0.5 * (symmetric - antisymmetric)
    return Receptance(frequency, same, other, _lateral(p, frequency, sources, receivers))


def _lateral(
    p: TrackParameters, frequency: np.ndarray, sources: np.ndarray, receivers: np.ndarray
) -> np.ndarray:
    """Lateral and roll receptance of the head, (f, receivers, sources, 2, 2)."""
    result = np.zeros((frequency.size, receivers.size, sources.size, 2, 2), dtype=complex)
    if p.rail.motion == "vertical":
        return result
    response = LateralResponse(assemble_lateral(p), sources, receivers)
    head = np.array([[1.0, p.rail.axis_depth], [0.0, 1.0]])
    for i, f in enumerate(frequency):
        result[i] = head @ response.solve(2j * np.pi * f) @ head.T
    return result

r"""Lateral bending and torsion of one rail on its fasteners, one internal step.

Both rails have the same system, and the slabs do not move sideways. The rail's axis
(its centroid) moves by y and turns by :math:`\varphi`; its foot, :math:`h_f` below, moves
by :math:`y - h_f\varphi`. A fastener holds the foot with a lateral force p and, through the
width b of the rail base, at whose edges the two halves of its vertical spring stand, with
a moment m:

.. math:: p = k_l (y - h_f\varphi) + \ldots,\quad m = k_v\tfrac{b^2}{4}\varphi + \ldots

Fasteners are alike and equidistant, so waves that look different at the fasteners do not
couple: in the folded wave numbers of :mod:`slab_track.waves` the fasteners are 2 x 2
problems, one per row. The modes left out act at the wheels only, with their static
compliance; at the fasteners they are below one per cent.
"""

from typing import NamedTuple

import numpy as np

from slab_track.parameters import TrackParameters
from slab_track.rail import RailModes, timoshenko_modes
from slab_track.waves import fastener_shapes, fold_table, waves

PHASES = 64
"""Places between two fasteners for which the compliance at a wheel is tabulated."""


class LateralTrack(NamedTuple):
    """Lateral and torsional modes of a rail and its fasteners.

    Attributes
    ----------
    bending
        Lateral Timoshenko modes.
    torsion_omega_squared, torsion_amplitude
        Torsional modes, shape (N,), rad2/s2 and kg^-1/2 m^-1.
    fold_index, fold_sign
        As in :class:`slab_track.assembly.LinearTrack`.
    class_weight
        Sum of the squares of a folded shape over the fasteners, (P,).
    stiffness, damping
        Of one fastener: lateral (N/m, N.s/m) and against roll (N.m/rad, N.m.s/rad), (2,).
    foot
        Height of the axis above the rail base h_f, m.
    residual
        Static compliance of the modes left out under a wheel: lateral (m/N) and in
        roll (rad/(N.m)), (2,).
    length
        Of the window, m.
    """

    bending: RailModes
    torsion_omega_squared: np.ndarray
    torsion_amplitude: np.ndarray
    fold_index: np.ndarray
    fold_sign: np.ndarray
    class_weight: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    foot: float
    residual: np.ndarray
    length: float


def assemble_lateral(p: TrackParameters) -> LateralTrack:
    """Build the lateral and torsional system of a rail from the track's parameters."""
    rail, fastener, length = p.rail, p.fastener, p.window_length
    bending_stiffness = rail.youngs_modulus * rail.lateral_second_moment
    shear_stiffness = rail.lateral_shear_coefficient * rail.shear_modulus * rail.area
    along = waves(length, p.rail_mode_count, ring=p.ring)
    bending = timoshenko_modes(
        along,
        bending_stiffness=bending_stiffness,
        shear_stiffness=shear_stiffness,
        mass_per_length=rail.density * rail.area,
        rotary_inertia=rail.density * rail.lateral_second_moment,
    )
    polar = rail.density * rail.polar_second_moment
    count = p.fastener_count
    index, sign = fold_table(p.rail_mode_count, count, ring=p.ring)
    weight = np.sum(fastener_shapes(count, ring=p.ring) ** 2, axis=1)
    # Half the vertical spring under either edge of the rail base.
    lever = rail.base_width**2 / 4.0
    residual = np.zeros(2)
    if rail.residual_compliance:
        finer = waves(length, 200 * p.rail_mode_count, ring=p.ring).wave_number
        wave = finer[along.wave_number.size :]
        residual[0] = np.sum(
            1.0 / (bending_stiffness * wave**4) + 1.0 / (shear_stiffness * wave**2)
        )
        residual[1] = np.sum(1.0 / (rail.torsional_stiffness * wave**2))
        residual /= length  # 2/l times the mean square 1/2
    return LateralTrack(
        bending=bending,
        torsion_omega_squared=rail.torsional_stiffness * bending.wave_number**2 / polar,
        torsion_amplitude=1.0 / np.sqrt(polar * length * along.mean_square),
        fold_index=index,
        fold_sign=sign,
        class_weight=weight,
        stiffness=np.array([fastener.lateral_stiffness, fastener.vertical_stiffness * lever]),
        damping=np.array([fastener.lateral_damping, fastener.vertical_damping * lever]),
        foot=rail.axis_height,
        residual=residual,
        length=length,
    )


class LateralOperator(NamedTuple):
    """Constants of a rail's lateral and torsional step.

    Attributes
    ----------
    softening
        alpha omega^2 of the three branches (bending, shear, torsion), shape (3N,).
    weight, amplitude
        alpha, and displacement per unit coordinate phi, shape (3, N).
    drive
        alpha phi, shape (3, N).
    response
        Displacement amplitude per unit wave force: lateral, roll; h^2/4 beta, shape (2, N).
    solve
        Inverse of the fasteners' 2 x 2 problems, shape (2, 2, P).
    gain
        k + 2c/h of the two directions, (2,).
    compliance
        Under a wheel: y per force, y per moment (= roll per force), roll per moment, modal
        part, over the place between two fasteners, shape (PHASES + 3, 3).
    """

    softening: np.ndarray
    weight: np.ndarray
    amplitude: np.ndarray
    drive: np.ndarray
    response: np.ndarray
    solve: np.ndarray
    gain: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    class_weight: np.ndarray
    fold_index: np.ndarray
    fold_sign: np.ndarray
    foot: float
    residual: np.ndarray
    compliance: np.ndarray
    spacing: float


def lateral_operator(track: LateralTrack, step: float) -> LateralOperator:
    """Return the operator for an internal step in s."""
    quarter = 0.25 * step**2
    omega_squared = np.vstack([track.bending.omega_squared, track.torsion_omega_squared])
    operator = _operator(
        track,
        weight=1.0 / (1.0 + quarter * omega_squared),
        scale=quarter,
        gain=track.stiffness + 2.0 / step * track.damping,
    )
    return operator._replace(compliance=_compliance_table(operator, track))


def _operator(
    track: LateralTrack, *, weight: np.ndarray, scale: float, gain: np.ndarray
) -> LateralOperator:
    """Build an operator from the coordinates' responses ``scale * weight`` to modal forces."""
    amplitude = np.vstack([track.bending.deflection, track.torsion_amplitude])
    share = amplitude**2 * weight
    response = scale * np.stack([share[0] + share[1], share[2]])
    omega_squared = np.vstack([track.bending.omega_squared, track.torsion_omega_squared])
    return LateralOperator(
        softening=(weight * omega_squared).ravel(),
        weight=weight,
        amplitude=amplitude,
        drive=weight * amplitude,
        response=response,
        solve=_fastener_inverse(track, response, gain),
        gain=gain,
        stiffness=track.stiffness,
        damping=track.damping,
        class_weight=track.class_weight,
        fold_index=track.fold_index,
        fold_sign=track.fold_sign,
        foot=track.foot,
        residual=track.residual,
        compliance=np.zeros((PHASES + 3, 3)),
        spacing=track.length / track.class_weight.size,
    )


def static_rail(
    track: LateralTrack, positions: np.ndarray, forces: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the equilibrium of a rail under forces and roll moments on its axis.

    ``positions`` (w,) in m from the window's start, ``forces`` (w, 2) in N and N.m.
    Returns the coordinates (3, N) and displacement and roll of the axis there, (w, 2).
    """
    omega_squared = np.vstack([track.bending.omega_squared, track.torsion_omega_squared])
    rigid = omega_squared == 0.0
    spring = float(
        np.max(track.stiffness) * np.max(track.class_weight) * track.torsion_amplitude[0] ** 2
    )
    operator = _operator(
        track, weight=1.0 / np.where(rigid, spring, omega_squared), scale=1.0, gain=track.stiffness
    )
    shapes = track.bending.waves.shapes(positions).T
    coordinates = _sprung(operator, forces.T @ shapes)
    coordinates += _without_springs(operator, coordinates, rigid, spring)
    wave = operator.amplitude * coordinates
    motion = shapes @ np.stack([wave[0] + wave[1], wave[2]]).T + forces * track.residual
    return coordinates, motion


def _without_springs(
    operator: LateralOperator, coordinates: np.ndarray, rigid: np.ndarray, spring: float
) -> np.ndarray:
    """Return what ``coordinates`` lack because modes that only fasteners hold had springs.

    With A the answer of the sprung rail, q = A (f + spring q) on these modes, which are those
    of a ring that moves or turns as a whole; a hinged rail has none.
    """
    answers = []
    for branch, wave in np.argwhere(rigid):
        load = np.zeros((2, coordinates.shape[1]))
        load[branch // 2, wave] = spring / operator.amplitude[branch, wave]
        answers.append(_sprung(operator, load))
    if not answers:
        return np.zeros_like(coordinates)
    own = np.stack([answer[rigid] for answer in answers], axis=1)
    motion = np.linalg.solve(np.eye(len(answers)) - own, coordinates[rigid])
    return np.tensordot(motion, np.stack(answers), axes=1)


def _sprung(operator: LateralOperator, load: np.ndarray) -> np.ndarray:
    """Coordinates (3, N) under wave forces and moments (2, N), fasteners included."""
    extension = _extension(operator, operator.response * load)
    net = load - _fastener_wave_force(operator, _solve_fasteners(operator, extension))
    return operator.weight * operator.amplitude * net[[0, 0, 1]]


def _fastener_inverse(track: LateralTrack, response: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """Invert 1 + gain * admittance for every folded wave number, shape (2, 2, P)."""
    folded = np.zeros((2, track.class_weight.size))
    for direction in (0, 1):
        np.add.at(folded[direction], track.fold_index, response[direction] * track.fold_sign**2)
    lateral, roll = folded * track.class_weight
    foot = track.foot
    matrix = np.empty((track.class_weight.size, 2, 2))
    matrix[:, 0, 0] = 1.0 + gain[0] * (lateral + foot**2 * roll)
    matrix[:, 0, 1] = -gain[0] * foot * roll
    matrix[:, 1, 0] = -gain[1] * foot * roll
    matrix[:, 1, 1] = 1.0 + gain[1] * roll
    return np.ascontiguousarray(np.moveaxis(np.linalg.inv(matrix), 0, 2))


def _compliance_table(operator: LateralOperator, track: LateralTrack) -> np.ndarray:
    """Response under a wheel in the middle of the window, for places between fasteners."""
    wave, count = track.bending.waves, track.class_weight.size
    middle = count // 2 + 0.5
    table = np.empty((PHASES + 3, 3))
    for row in range(PHASES + 3):
        x = (middle + (row - 1) / PHASES) * operator.spacing
        shape = wave.shapes(np.array([x]))[:, 0]
        force, moment = np.zeros((2, shape.size)), np.zeros((2, shape.size))
        force[0], moment[1] = shape, shape
        answers = []
        for load in (force, moment):
            free = np.stack([operator.response[0] * load[0], operator.response[1] * load[1]])
            held = free - operator.response * _fastener_wave_force(
                operator, _solve_fasteners(operator, _extension(operator, free))
            )
            answers.append(held @ shape)
        table[row] = answers[0][0], answers[0][1], answers[1][1]
    return table


def _extension(operator: LateralOperator, displacement: np.ndarray) -> np.ndarray:
    """Force on held fasteners for displacements made within a step, folded, shape (2, P)."""
    foot = displacement[0] - operator.foot * displacement[1]
    folded = np.zeros((2, operator.class_weight.size))
    np.add.at(folded[0], operator.fold_index, operator.fold_sign * foot)
    np.add.at(folded[1], operator.fold_index, operator.fold_sign * displacement[1])
    return folded * operator.gain[:, None]


def _solve_fasteners(operator: LateralOperator, extension: np.ndarray) -> np.ndarray:
    """Return lateral force and moment of the fasteners, folded, shape (2, P)."""
    return np.einsum("ijp,jp->ip", operator.solve, extension)


def _fastener_wave_force(operator: LateralOperator, force: np.ndarray) -> np.ndarray:
    """Wave force and moment that the fasteners take from the rail, shape (2, N)."""
    taken = operator.class_weight * np.stack([force[0], force[1] - operator.foot * force[0]])
    return operator.fold_sign * taken[:, operator.fold_index]

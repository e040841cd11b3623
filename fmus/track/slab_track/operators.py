"""Constants of the kernels for one internal step size, made from the linear track."""

import numpy as np

from slab_track.assembly import LinearTrack
from slab_track.branches import make_branches
from slab_track.folding import make_aliasing, sum_order
from slab_track.halves import half_size, split_matrix
from slab_track.kernel import kernel_table
from slab_track.kernels.lateral import LateralConstants, LateralWork
from slab_track.kernels.shift import ShiftConstants
from slab_track.kernels.transforms import make_transform
from slab_track.kernels.vertical import VerticalConstants, VerticalWork
from slab_track.lateral import LateralTrack, lateral_operator
from slab_track.parameters import TrackParameters
from slab_track.slide import BySamples, SlideOperator
from slab_track.waves import fastener_shapes, samples_per_bay


def vertical_constants(track: LinearTrack, step: float) -> VerticalConstants:
    """Return the constants of rails, slabs and fasteners for an internal step in s."""
    quarter, count, ring = 0.25 * step**2, track.fastener_count, track.ring
    weight = 1.0 / (1.0 + quarter * track.rail.omega_squared)
    beta = np.sum(track.participation**2 * weight, axis=0)
    dampers = track.damping + track.end_damping
    nu = track.stiffness + 2.0 / step * dampers
    modal = kernel_table(quarter * beta, count, ring=ring)
    residual = kernel_table(track.residual_flexibility, count, ring=ring)
    modes = max(slab.omega_squared.size for slab in track.slabs)
    half, seats = half_size(count), track.seat_count
    softening, drag, weights = (np.zeros((2, modes)) for _ in range(3))
    shapes, solve = np.zeros((2, modes, seats)), np.zeros((2, 2, half, half))
    for symmetry, slab in enumerate(track.slabs):
        own = slice(slab.omega_squared.size)
        alpha = 1.0 / (1.0 + 0.5 * step * slab.damping + quarter * slab.omega_squared)
        weights[symmetry, own] = alpha
        softening[symmetry, own] = alpha * slab.omega_squared
        drag[symmetry, own] = alpha * slab.damping
        shapes[symmetry, own] = slab.seats
        admittance = track.fastener_admittance(weight, alpha, symmetry)
        flexibility = quarter * admittance + track.fastener_residual(symmetry)
        inverse = np.linalg.inv(np.diag(1.0 / nu) + flexibility)
        solve[symmetry] = split_matrix(0.5 * (inverse + inverse.T))
    return VerticalConstants(
        rail_softening=weight * track.rail.omega_squared,
        rail_participation=track.participation,
        rail_drive=weight * track.participation,
        wave_number=track.rail.wave_number,
        aliasing=make_aliasing(track.fold_index, track.fold_sign, track.fastener_sines),
        modal_kernel=modal,
        whole_kernel=modal + residual,
        fastener_damping=dampers,
        fastener_flexibility=1.0 / nu,
        slab_softening=softening,
        slab_drag=drag,
        slab_weight=weights,
        seats=shapes,
        from_seats=np.ascontiguousarray(shapes.swapaxes(1, 2)),
        solve=solve,
        spacing=track.length / count,
        ring=ring,
    )


def vertical_work(constants: VerticalConstants, wheelsets: int) -> VerticalWork:
    """Return memory for a step."""
    w, half = wheelsets, constants.solve.shape[-1]
    waves, (_, modes, seats) = constants.wave_number.size, constants.seats.shape
    count = constants.fastener_damping.size
    return VerticalWork(
        by_modes=np.zeros((2, w, half)),
        compliance_to_fasteners=np.zeros((2, w, half)),
        own_by_modes=np.zeros(w),
        between_wheels=np.zeros((w, w)),
        compression=np.zeros((2, 2, half)),
        fastener=np.zeros((2, 2, half)),
        fastener_by_wheel=np.zeros((2, 2, w, half)),
        deflection=np.zeros((2, w)),
        rate=np.zeros((2, w)),
        compliance=np.zeros((2, w, w)),
        mobility=np.zeros((2, w)),
        amplitude=np.zeros(waves),
        amplitude_rate=np.zeros(waves),
        wave_force=np.zeros(waves),
        sums=np.zeros(2 * half),
        parts=np.zeros((2, half)),
        at_fasteners=np.zeros(count),
        at_seats=np.zeros((count // seats, seats)),
        slab_force=np.zeros((count // seats, modes)),
    )


def lateral_constants(track: LateralTrack, step: float) -> LateralConstants:
    """Return the constants of a rail's lateral motion for an internal step in s."""
    operator, count = lateral_operator(track, step), track.class_weight.size
    order = sum_order(fastener_shapes(count, ring=track.bending.waves.ring))
    half = half_size(count)
    solve, weight = np.zeros((4, 2 * half)), np.zeros(2 * half)
    solve[:, order], weight[order] = operator.solve.reshape(4, count), track.class_weight
    return LateralConstants(
        softening=operator.softening.reshape(operator.amplitude.shape),
        amplitude=operator.amplitude,
        drive=operator.drive,
        response=operator.response,
        solve=solve,
        weight=weight,
        gain=operator.gain,
        stiffness=operator.stiffness,
        damping=operator.damping,
        residual=operator.residual,
        compliance=operator.compliance,
        foot=operator.foot,
        spacing=operator.spacing,
    )


def lateral_work(constants: LateralConstants, wheelsets: int) -> LateralWork:
    """Return memory for a step."""
    waves, sums = constants.softening.shape[1], constants.weight.size
    return LateralWork(
        fastener_left=np.zeros((2, sums)),
        fastener_right=np.zeros((2, sums)),
        fastener_load=np.zeros((2, sums)),
        motion_left=np.zeros((wheelsets, 4)),
        motion_right=np.zeros((wheelsets, 4)),
        waves=np.zeros((4, waves)),
        force=np.zeros((2, waves)),
        flexible=np.zeros(3),
    )


def shifts_by_samples(operator: SlideOperator) -> bool:
    """Whether the kernels can shift the window: by transforms, eqs. (9) and (11) alone."""
    maps = operator.deflection, operator.rotation
    return all(isinstance(of, BySamples) for of in maps) and not operator.constrained


def shift_constants(
    parameters: TrackParameters,
    track: LinearTrack,
    lateral: LateralTrack,
    operator: SlideOperator,
) -> ShiftConstants:
    """Return the constants of a shift; of no use unless :func:`shifts_by_samples`."""
    waves = track.rail.wave_number.size
    deflection, kept, segments = operator.deflection, np.zeros(0), 0
    count = bay = 1
    if shifts_by_samples(operator) and isinstance(deflection, BySamples):
        count, kept, segments = deflection.count, deflection.kept, deflection.shift
        bay = samples_per_bay(waves, track.fastener_count)
    slabs = round(operator.shift / track.pitch)
    fasteners = slabs * track.seat_count
    points = bay * track.fastener_count
    return ShiftConstants(
        vertical=make_branches(track.rail),
        lateral=make_branches(lateral.bending),
        participation=track.participation,
        kept=kept,
        deflection=make_transform(count, 18),
        rotation=make_transform(count, 12),
        field=make_transform(points, 8),
        deflection_rows=np.zeros((18, count)),
        rotation_rows=np.zeros((12, count)),
        field_rows=np.zeros((8, points)),
        shift=operator.shift,
        segments=segments,
        slabs=slabs,
        fasteners=fasteners,
        points=bay * fasteners,
        bay=bay,
    )

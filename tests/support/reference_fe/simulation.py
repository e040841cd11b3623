"""A vehicle runs over the line from static equilibrium."""

from dataclasses import dataclass
from math import ceil

import numpy as np
import scipy.linalg

from .amplitude import band_limited_amplitude
from .beam import HALF_BANDWIDTH, shape_coefficients
from .kernel import (
    Columns,
    Record,
    Scheme,
    State,
    TrackOperators,
    VehicleOperators,
    run,
    solve_factored,
)
from .line import Line, build_line, static_compliance
from .parameters import ReferenceTrack, ReferenceVehicle, SingleWheel
from .rolling_stock import RollingStock, rolling_stock


@dataclass(frozen=True, kw_only=True)
class ReferenceResult:
    """Histories of a run; `side` has length 1 where left and right are alike.

    Attributes
    ----------
    time : ndarray, shape (time,)
        s.
    position : ndarray, shape (time, wheelset)
        m from the line's start.
    wheel_force : ndarray, shape (time, wheelset, side)
        Contact force per wheel in N, positive in compression.
    wheelset_acceleration : ndarray, shape (time, wheelset)
        Vertical, positive downward, m/s2.
    axle_box_acceleration : ndarray, shape (time, wheelset, side)
        The same at the axle boxes (it differs where a wheelset rolls).
    wheelset_displacement : ndarray, shape (time, wheelset)
        m, downward.
    rail_displacement : ndarray, shape (time, wheelset, side)
        Rail under the wheel in m, downward.
    body_displacement : ndarray, shape (time, dof)
        All degrees of freedom of the vehicle.
    dissipated_power, driving_power : ndarray, shape (time,)
        W; the former only with ``record_energy``.
    initial_energy, final_energy : float
        Sum of all kinetic and potential energies in J.
    slab_passing_time : float
        s.
    """

    time: np.ndarray
    position: np.ndarray
    wheel_force: np.ndarray
    wheelset_acceleration: np.ndarray
    axle_box_acceleration: np.ndarray
    wheelset_displacement: np.ndarray
    rail_displacement: np.ndarray
    body_displacement: np.ndarray
    dissipated_power: np.ndarray
    driving_power: np.ndarray
    initial_energy: float
    final_energy: float
    slab_passing_time: float

    def amplitude(self, signal: np.ndarray, f_max: float = 500.0, pitches: int = 1) -> np.ndarray:
        """`band_limited_amplitude` over the last slab pitches."""
        return band_limited_amplitude(self.time, signal, f_max, pitches * self.slab_passing_time)

    def periodicity_defect(self, signal: np.ndarray, f_max: float = 500.0) -> np.ndarray:
        """Amplitude of the change since one slab before, over that of the signal."""
        count = round(self.slab_passing_time / self.time[1])
        change = signal[count:] - signal[:-count]
        defect = band_limited_amplitude(self.time[count:], change, f_max, self.slab_passing_time)
        return defect / self.amplitude(signal, f_max)


def simulate(
    track: ReferenceTrack,
    vehicle: ReferenceVehicle | SingleWheel,
    speed: float,
    distance: float,
    *,
    step: float = 2.5e-5,
    spectral_radius: float = 0.8,
    margin: float = 15.0,
    start_phase: float = 0.0,
    two_sided: bool = False,
    record_energy: bool = False,
) -> ReferenceResult:
    """Run a vehicle at constant speed over a smooth track.

    The start is static equilibrium with all velocities zero; then the wheels move at once.

    Parameters
    ----------
    speed : float
        m/s.
    distance : float
        Way of each wheelset in m; rounded up to whole steps.
    step : float
        Largest step in s; it is cut so that it divides the passing time of a fastener bay.
    spectral_radius : float
        Of the generalised-alpha method at infinite frequency, 0 to 1 (1: no numerical damping).
    margin : float
        Least distance of any wheel from either end of the line in m. Lightly damped pads
        (10 kN s/m) need 15-20 m.
    start_phase : float
        Start of the leading wheelset after the middle between two fasteners, in m.
    two_sided : bool
        Model both rails even if both loads are equal.
    record_energy : bool
        Record the dissipated power (costs time).
    """
    stock = rolling_stock(vehicle, track.rail_distance, two_sided=two_sided)
    steps_per_bay = ceil(track.fastener_spacing / (speed * step) - 1e-9)
    scheme = make_scheme(track.fastener_spacing / (speed * steps_per_bay), spectral_radius)
    rows = ceil(distance / (speed * scheme.step) - 1e-9) + 1
    lead = track.fastener_spacing * ceil(
        (margin - stock.axle_positions.min()) / track.fastener_spacing
    )
    start = lead + start_phase + stock.axle_positions
    end = start.max() + speed * scheme.step * (rows - 1) + margin
    slab_count = ceil(end / track.pitch)
    lines = [build_line(track, slab_count, "symmetric")]
    if stock.sides == 2:
        lines.append(build_line(track, slab_count, "antisymmetric"))
    operators = track_operators(lines, scheme)
    vehicle_operators = _vehicle_operators(stock, scheme)
    state, record = _static_start(lines, operators, stock, start, rows)
    initial_energy = total_energy(lines, stock, state, start)
    run(
        operators,
        vehicle_operators,
        scheme,
        state,
        _columns(lines, len(start)),
        start,
        speed,
        record,
        record_energy,
    )
    time = scheme.step * np.arange(rows)
    positions = start + speed * time[:, None]
    shape = (rows, len(start), stock.sides)
    return ReferenceResult(
        time=time,
        position=positions,
        wheel_force=record.force.reshape(shape),
        wheelset_acceleration=record.body_acceleration @ stock.wheelset.T,
        axle_box_acceleration=(record.body_acceleration @ stock.box.T).reshape(shape),
        wheelset_displacement=record.body @ stock.wheelset.T,
        rail_displacement=record.deflection.reshape(shape),
        body_displacement=record.body,
        dissipated_power=record.power[:, 0],
        driving_power=record.power[:, 1],
        initial_energy=initial_energy,
        final_energy=total_energy(lines, stock, state, positions[-1]),
        slab_passing_time=track.pitch / speed,
    )


def make_scheme(step: float, spectral_radius: float) -> Scheme:
    """Constants of the generalised-alpha method."""
    alpha_m = (2 * spectral_radius - 1) / (spectral_radius + 1)
    alpha_f = spectral_radius / (spectral_radius + 1)
    return Scheme(
        step=step,
        alpha_m=alpha_m,
        alpha_f=alpha_f,
        beta=0.25 * (1 - alpha_m + alpha_f) ** 2,
        gamma=0.5 - alpha_m + alpha_f,
    )


def track_operators(lines: list[Line], scheme: Scheme) -> TrackOperators:
    """Factor the rail's step matrix and eliminate the slabs down to the pads."""
    line, track = lines[0], lines[0].track
    bu, gu = scheme.beta * scheme.step**2, scheme.gamma * scheme.step
    old, new = 1 - scheme.alpha_m, 1 - scheme.alpha_f
    step_matrix = old * line.rail_mass + new * bu * line.rail_stiffness
    lower, inverse_diagonal = _factor(step_matrix)
    pads = line.pad_dofs
    rail_at_pads = np.zeros((len(pads), len(pads)))
    for p, dof in enumerate(pads):
        column = np.zeros(line.rail_dofs)
        column[dof] = 1.0
        solve_factored(lower, inverse_diagonal, column)
        rail_at_pads[p] = column[pads]
    pad_gain = new * (track.pad_stiffness * bu + track.pad_damping * gu)
    inverses, solvers = [], []
    for half in lines:
        slab = half.slab
        inverse = 1 / (old + new * (gu * slab.damping + bu * slab.stiffness))
        seats = slab.seat_shape * inverse @ slab.seat_shape.T
        total = rail_at_pads + np.kron(np.eye(half.slab_count), seats)
        solvers.append(np.linalg.inv(np.eye(len(pads)) + pad_gain * total))
        inverses.append(inverse)
    sign = np.array([[1.0, 1.0], [1.0, -1.0]])[: len(lines), : len(lines)]
    return TrackOperators(
        mass=line.rail_mass,
        stiffness=line.rail_stiffness,
        lower=lower,
        inverse_diagonal=inverse_diagonal,
        pad_dofs=pads,
        pad_stiffness=track.pad_stiffness,
        pad_damping=track.pad_damping,
        pad_gain=pad_gain,
        pad_solver=np.array(solvers),
        seat_shape=np.array([half.slab.seat_shape for half in lines]),
        slab_stiffness=np.array([half.slab.stiffness for half in lines]),
        slab_damping=np.array([half.slab.damping for half in lines]),
        slab_inverse=np.array(inverses),
        family_sign=sign,
        element_length=line.element_length,
        shapes=shape_coefficients(line.section, line.element_length),
        bending_stiffness=line.section.bending_stiffness,
        shear_stiffness=line.section.shear_stiffness,
    )


def _factor(diagonals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit lower factor by rows (dof, 3) and inverse diagonal of a banded matrix."""
    size = diagonals.shape[1]
    cholesky = scipy.linalg.cholesky_banded(diagonals[HALF_BANDWIDTH:], lower=True)
    lower = np.zeros((size, HALF_BANDWIDTH))
    for d in range(1, HALF_BANDWIDTH + 1):
        lower[d:, d - 1] = cholesky[d, :-d] / cholesky[0, :-d]
    return lower, cholesky[0] ** -2


def _vehicle_operators(stock: RollingStock, scheme: Scheme) -> VehicleOperators:
    new = 1 - scheme.alpha_f
    matrix = (1 - scheme.alpha_m) * stock.mass
    matrix = matrix + new * scheme.gamma * scheme.step * stock.damping
    matrix = matrix + new * scheme.beta * scheme.step**2 * stock.stiffness
    return VehicleOperators(
        inverse_mass=np.linalg.inv(stock.mass),
        mass=stock.mass,
        damping=np.ascontiguousarray(stock.damping),
        stiffness=np.ascontiguousarray(stock.stiffness),
        inverse=np.linalg.inv(matrix),
        load=stock.load,
        contact=np.ascontiguousarray(stock.contact),
        multiplicity=stock.multiplicity,
        hertz_constant=stock.hertz_constant,
    )


def _columns(lines: list[Line], wheels: int) -> Columns:
    pads = len(lines[0].pad_dofs)
    return Columns(
        first=np.full(wheels, 0),
        rail=np.zeros((wheels, 4, lines[0].rail_dofs)),
        at_pads=np.zeros((4 * wheels, pads)),
        pad_force=np.zeros((len(lines), 4 * wheels, pads)),
        compliance=np.zeros((len(lines), 4 * wheels, 4 * wheels)),
    )


def static_equilibrium(
    lines: list[Line], stock: RollingStock, positions: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vehicle at rest on the track, by Newton's method on vehicle dofs and penetrations.

    Returns
    -------
    body, force, penetration : ndarray
        Vehicle dofs; wheel forces in N and Hertzian approaches in m, per contact.
    """
    sides = len(lines)
    compliance = np.zeros((len(stock.contact), len(stock.contact)))
    for f, line in enumerate(lines):
        _, direct = static_compliance(line, positions)
        sign = np.array([[1.0, 1.0], [1.0, -1.0]])[:sides, f]
        compliance += np.kron(direct, np.outer(sign, sign)) / sides
    count, dofs = len(compliance), len(stock.mass)
    body = np.zeros(dofs)
    penetration = np.full(count, 1e-4)
    for _ in range(50):
        force = (np.maximum(penetration, 0) / stock.hertz_constant) ** 1.5
        slope = 1.5 * np.sqrt(np.maximum(penetration, 0)) / stock.hertz_constant**1.5
        pressed = stock.multiplicity * stock.contact.T
        residual = np.concatenate(
            [
                stock.load - stock.stiffness @ body - pressed @ force,
                stock.contact @ body - compliance @ force - penetration,
            ]
        )
        jacobian = np.block(
            [
                [stock.stiffness, pressed * slope],
                [-stock.contact, np.eye(count) + compliance * slope],
            ]
        )
        change = np.linalg.solve(jacobian, residual)
        body, penetration = body + change[:dofs], penetration + change[dofs:]
        if np.abs(change[dofs:]).max() < 1e-15:
            break
    return body, force, penetration


def _static_start(
    lines: list[Line],
    operators: TrackOperators,
    stock: RollingStock,
    positions: np.ndarray,
    rows: int,
) -> tuple[State, Record]:
    body, force, penetration = static_equilibrium(lines, stock, positions)
    line, sides, contacts = lines[0], len(lines), len(force)
    modes = line.slab.seat_shape.shape[1]
    state = State(
        rail=np.zeros((3, sides, line.rail_dofs)),
        rail_force=np.zeros((sides, line.rail_dofs)),
        slab=np.zeros((3, sides, line.slab_count, modes)),
        slab_force=np.zeros((sides, line.slab_count, modes)),
        body=np.zeros((3, len(body))),
        force=force,
        penetration=penetration,
    )
    state.body[0] = body
    record = Record(
        force=np.zeros((rows, contacts)),
        deflection=np.zeros((rows, contacts)),
        body=np.zeros((rows, len(body))),
        body_acceleration=np.zeros((rows, len(body))),
        power=np.zeros((rows, 2)),
    )
    record.force[0], record.body[0] = force, body
    record.deflection[0] = stock.contact @ body - penetration
    for f, half in enumerate(lines):
        share = force.reshape(-1, sides) @ operators.family_sign[:, f] / sides
        response = static_compliance(half, positions)[0] @ share
        state.rail[0, f] = response[: line.rail_dofs]
        state.slab[0, f] = response[line.rail_dofs :].reshape(half.slab_count, modes)
        # At rest nodal forces balance the elastic ones.
        state.slab_force[f] = half.slab.stiffness * state.slab[0, f]
        seats = (state.slab[0, f] @ half.slab.seat_shape.T).ravel()
        load = half.load_vectors(positions)[: line.rail_dofs] @ share
        load[line.pad_dofs] -= half.track.pad_stiffness * (state.rail[0, f, line.pad_dofs] - seats)
        state.rail_force[f] = load
    return state, record


def total_energy(
    lines: list[Line], stock: RollingStock, state: State, positions: np.ndarray
) -> float:
    """Kinetic and potential energy of track, contacts and vehicle (with its weight) in J."""
    sides = len(lines)
    energy = 0.0
    for f, line in enumerate(lines):
        mass, _, stiffness = line.matrices()
        u, v = (np.concatenate([state.rail[i, f], state.slab[i, f].ravel()]) for i in (0, 1))
        energy += 0.5 * sides * (u @ (stiffness @ u) + v @ (mass @ v))
    local = np.repeat(lines[0].local_compliances(positions), sides)
    energy += (0.4 * state.force * np.maximum(state.penetration, 0.0)).sum()
    energy += (0.5 * local * state.force**2).sum()
    z, rate = state.body[0], state.body[1]
    own = 0.5 * (z @ stock.stiffness @ z + rate @ stock.mass @ rate) - stock.load @ z
    return float(stock.multiplicity * energy + own)

"""A vehicle runs over the line from static equilibrium."""

from dataclasses import dataclass
from math import ceil

import numpy as np

from .amplitude import band_limited_amplitude
from .containers import Record, State
from .equilibrium import static_start, total_energy
from .kernel import run
from .line import build_line
from .operators import empty_columns, make_scheme, track_operators, vehicle_operators
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
    if margin < track.fastener_spacing:
        raise ValueError(
            f"margin = {margin} m: keep the wheels at least one bay ({track.fastener_spacing} m) "
            "from the hinged ends, 15 m for results free of them"
        )
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
    state = static_start(lines, stock, start)
    record = _record(stock, state, rows)
    initial_energy = total_energy(lines, stock, state, start)
    run(
        track_operators(lines, scheme),
        vehicle_operators(stock, scheme),
        scheme,
        state,
        empty_columns(lines, len(start)),
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


def _record(stock: RollingStock, state: State, rows: int) -> Record:
    """Empty record whose first row is the state at rest."""
    contacts, dofs = stock.contact.shape
    record = Record(
        force=np.zeros((rows, contacts)),
        deflection=np.zeros((rows, contacts)),
        body=np.zeros((rows, dofs)),
        body_acceleration=np.zeros((rows, dofs)),
        power=np.zeros((rows, 2)),
    )
    record.force[0], record.body[0] = state.force, state.body[0]
    record.deflection[0] = stock.contact @ state.body[0] - state.penetration
    return record

"""Vertical equations of the wheel or the vehicle, z down, roll about x, pitch about y."""

from dataclasses import dataclass

import numpy as np

from .parameters import GRAVITY, ReferenceVehicle, SingleWheel


@dataclass(frozen=True, kw_only=True)
class RollingStock:
    """``mass a + damping v + stiffness z = load - multiplicity * contact.T @ force``.

    Attributes
    ----------
    contact : ndarray, shape (contact, dof)
        Height of each wheel's contact; order: wheelset, then side.
    box : ndarray, shape (box, dof)
        Height of each axle box (or the wheel), same order.
    wheelset : ndarray, shape (wheelset, dof)
        Height of each wheelset's centre.
    multiplicity : float
        Wheels that one contact stands for: 2 if a whole wheelset meets one modelled rail.
    sides : int
        1 if left and right are alike, otherwise 2.
    """

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    load: np.ndarray
    contact: np.ndarray
    box: np.ndarray
    wheelset: np.ndarray
    multiplicity: float
    sides: int
    axle_positions: np.ndarray
    hertz_constant: float


def rolling_stock(
    vehicle: SingleWheel | ReferenceVehicle, rail_distance: float, *, two_sided: bool = False
) -> RollingStock:
    """Equations of a vehicle; both sides only where loads differ or it is asked for."""
    sides = 2 if two_sided or not vehicle.symmetric else 1
    if isinstance(vehicle, SingleWheel):
        return _single_wheel(vehicle, sides)
    return _full_vehicle(vehicle, rail_distance, sides)


def _single_wheel(wheel: SingleWheel, sides: int) -> RollingStock:
    sprung = wheel.sprung_mass > 0
    weight = wheel.mass * GRAVITY
    masses = [wheel.mass, wheel.sprung_mass] if sprung else [wheel.mass]
    link = np.array([[1.0, -1.0], [-1.0, 1.0]]) if sprung else np.zeros((1, 1))
    load = [
        v
        for side in range(sides)
        for v in (
            [weight, wheel.static_load[side] - weight] if sprung else [wheel.static_load[side]]
        )
    ]
    contact = np.kron(np.eye(sides), np.eye(len(masses))[:1])
    return RollingStock(
        mass=np.diag(masses * sides).astype(float),
        damping=np.kron(np.eye(sides), wheel.suspension_damping * link),
        stiffness=np.kron(np.eye(sides), wheel.suspension_stiffness * link),
        load=np.array(load),
        contact=contact,
        box=contact,
        wheelset=contact.mean(axis=0, keepdims=True),
        multiplicity=1.0,
        sides=sides,
        axle_positions=wheel.axle_positions,
        hertz_constant=wheel.hertz_constant,
    )


# Bodies: car body, bogies 1-2, wheelsets 1-4; three dofs each: bounce, roll, pitch.
_BODIES = 7


def _suspension(v: ReferenceVehicle) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and damping over the dofs of all bodies."""
    stiffness, damping = np.zeros((2, 3 * _BODIES, 3 * _BODIES))

    def connect(a: np.ndarray, b: np.ndarray, k: float, c: float) -> None:
        stiffness[:] += k * np.outer(a - b, a - b)
        damping[:] += c * np.outer(a - b, a - b)

    lever, turn = (v.half_bogie_distance, -v.half_bogie_distance), np.eye(3 * _BODIES)
    arm = (v.half_wheelbase, -v.half_wheelbase)
    for j in range(2):
        connect(turn[1], turn[3 * (1 + j) + 1], v.anti_roll_stiffness, 0.0)
        for side in (-1, 1):
            y = side * v.secondary_half_span
            on_car, on_bogie = _point(0, lever[j], y), _point(1 + j, 0.0, y)
            connect(on_car, on_bogie, v.secondary_stiffness, v.secondary_damping)
            for i in range(2):
                y = side * v.primary_half_span
                on_bogie, on_box = _point(1 + j, arm[i], y), _point(3 + 2 * j + i, 0.0, y)
                connect(on_bogie, on_box, v.primary_stiffness, v.primary_damping)
    return stiffness, damping


def _full_vehicle(v: ReferenceVehicle, rail_distance: float, sides: int) -> RollingStock:
    stiffness, damping = _suspension(v)
    inertia = [(v.car_body_mass, v.car_body_roll_inertia, v.car_body_pitch_inertia)]
    inertia += 2 * [(v.bogie_mass, v.bogie_roll_inertia, v.bogie_pitch_inertia)]
    inertia += 4 * [(v.wheelset_mass, v.wheelset_roll_inertia, 1.0)]
    mass = np.concatenate(inertia)
    load = np.zeros(3 * _BODIES)
    load[::3] = GRAVITY * mass[::3]
    load[1] = GRAVITY * v.car_body_mass * v.load_offset
    reach = [0.0] if sides == 1 else [-0.5, 0.5]
    # Wheelsets do not pitch here (their spin carries no vertical load); roll only if sides differ.
    free = np.array(
        [not (d % 3 == 2 and d > 8) and not (d % 3 == 1 and sides == 1) for d in range(21)]
    )
    contact = np.array([_point(3 + i, 0.0, r * rail_distance) for i in range(4) for r in reach])
    box = np.array(
        [_point(3 + i, 0.0, 2 * r * v.primary_half_span) for i in range(4) for r in reach]
    )
    return RollingStock(
        mass=np.diag(mass[free]),
        damping=damping[np.ix_(free, free)],
        stiffness=stiffness[np.ix_(free, free)],
        load=load[free],
        contact=contact[:, free],
        box=box[:, free],
        wheelset=np.array([_point(3 + i, 0.0, 0.0) for i in range(4)])[:, free],
        multiplicity=2.0 / sides,
        sides=sides,
        axle_positions=v.axle_positions,
        hertz_constant=v.hertz_constant,
    )


def _point(body: int, x: float, y: float) -> np.ndarray:
    """Row that gives the height of a body's point (x forward, y right of its centre)."""
    row = np.zeros(3 * _BODIES)
    row[3 * body : 3 * body + 3] = 1.0, y, -x
    return row

"""Bodies and elements of the vehicle: what is attached where.

The geometry is documented in the package's README, section "Arrangement".
"""

import dataclasses

import numpy as np

from rail_vehicle.coordinates import (
    AXLE_SIGNS,
    BOGIE_OF_WHEELSET,
    BOGIE_SIGNS,
    BOGIES,
    CAR_BODY,
    COORDINATE_COUNT,
    PITCH,
    ROLL,
    SIDE_SIGNS,
    SIDES,
    WHEELSETS,
    YAW,
    box_coordinate,
    coordinate,
)
from rail_vehicle.multibody import Array, Body, Element, axle_box, rigid_body
from rail_vehicle.parameters import VehicleParameters


@dataclasses.dataclass(frozen=True, kw_only=True)
class Bodies:
    """All bodies: ``boxes`` is indexed ``[wheelset][side]``."""

    car_body: Body
    bogies: tuple[Body, ...]
    wheelsets: tuple[Body, ...]
    boxes: tuple[tuple[Body, Body], ...]


def bogie_positions(parameters: VehicleParameters) -> Array:
    """Longitudinal positions of the bogie centres in the car body, shape (2,), m."""
    return np.array(BOGIE_SIGNS) * parameters.car_body.half_bogie_spacing


def wheelset_positions(parameters: VehicleParameters) -> Array:
    """Longitudinal positions of the axles in the car body, shape (4,), m."""
    centres = bogie_positions(parameters)[list(BOGIE_OF_WHEELSET)]
    return centres + np.array(AXLE_SIGNS) * parameters.bogie.half_wheelbase


def make_bodies(parameters: VehicleParameters) -> Bodies:
    """Place the bodies; the origin is at the rails, below the car body's centre."""
    half_span = parameters.primary_suspension.half_span
    axle_z = -parameters.wheelset.radius
    car = rigid_body(
        "car_body", CAR_BODY, np.array([0.0, 0.0, -parameters.car_body.centre_of_gravity_height])
    )
    frame_z = -parameters.bogie.centre_of_gravity_height
    bogies = tuple(
        rigid_body(f"bogie[{index + 1}]", BOGIES[index], np.array([x, 0.0, frame_z]))
        for index, x in enumerate(bogie_positions(parameters))
    )
    wheelsets = tuple(
        rigid_body(f"wheelset[{index + 1}]", WHEELSETS[index], np.array([x, 0.0, axle_z]))
        for index, x in enumerate(wheelset_positions(parameters))
    )

    def box(index: int, side: int) -> Body:
        wheelset = wheelsets[index]
        position = wheelset.position + np.array([0.0, SIDE_SIGNS[side] * half_span, 0.0])
        name = f"axle_box[{index + 1}].{SIDES[side]}"
        return axle_box(name, wheelset, position, box_coordinate(index, side))

    boxes = tuple((box(index, 0), box(index, 1)) for index in range(4))
    return Bodies(car_body=car, bogies=bogies, wheelsets=wheelsets, boxes=boxes)


def linear_elements(parameters: VehicleParameters, bodies: Bodies) -> list[Element]:
    """All linear springs and dampers with their static preloads."""
    elements: list[Element] = []
    for bogie in bodies.bogies:
        elements += _secondary(parameters, bodies.car_body, bogie)
        elements.append(_anti_roll_bar(parameters, bodies.car_body, bogie))
    for index, pair in enumerate(bodies.boxes):
        for box in pair:
            frame = bodies.bogies[BOGIE_OF_WHEELSET[index]]
            elements += _primary(parameters, frame, box, AXLE_SIGNS[index])
    return elements


def _secondary(parameters: VehicleParameters, car: Body, bogie: Body) -> list[Element]:
    group = parameters.secondary_suspension
    load = parameters.car_body.mass * parameters.gravity / 4.0
    return [
        Element(
            upper=car,
            lower=bogie,
            point=np.array([bogie.position[0], sign * group.half_span, -group.height]),
            stiffness=np.array(
                [group.longitudinal_stiffness, group.lateral_stiffness, group.vertical_stiffness]
            ),
            damping=np.array(
                [group.longitudinal_damping, group.lateral_damping, group.vertical_damping]
            ),
            preload=np.array([0.0, 0.0, -load]),
        )
        for sign in SIDE_SIGNS
    ]


def _anti_roll_bar(parameters: VehicleParameters, car: Body, bogie: Body) -> Element:
    return Element(
        upper=car,
        lower=bogie,
        point=bogie.position,
        roll_stiffness=parameters.anti_roll_bar.roll_stiffness,
    )


def _primary(
    parameters: VehicleParameters, frame: Body, box: Body, axle_sign: float
) -> list[Element]:
    """Two coil springs with dampers fore and aft of the axle, and the guide's bush.

    The springs push vertically only, so their height has no lever and does not matter.
    """
    group = parameters.primary_suspension
    load = (parameters.car_body.mass + 2.0 * parameters.bogie.mass) * parameters.gravity / 8.0
    x, y, axle_z = box.position
    springs = [
        Element(
            upper=frame,
            lower=box,
            point=np.array([x + sign * group.spring_half_spacing, y, axle_z]),
            stiffness=np.array([0.0, 0.0, 0.5 * group.vertical_stiffness]),
            damping=np.array([0.0, 0.0, 0.5 * group.vertical_damping]),
            preload=np.array([0.0, 0.0, -0.5 * load]),
        )
        for sign in (1.0, -1.0)
    ]
    guide = Element(
        upper=frame,
        lower=box,
        point=np.array([x - axle_sign * group.guide_offset, y, -group.guide_height]),
        stiffness=np.array(
            [group.longitudinal_stiffness, group.lateral_stiffness, group.guide_vertical_stiffness]
        ),
        damping=np.array(
            [group.longitudinal_damping, group.lateral_damping, group.guide_vertical_damping]
        ),
    )
    return [*springs, guide]


def mass_matrix(parameters: VehicleParameters) -> Array:
    """Diagonal mass matrix of the 50 coordinates, shape (50, 50)."""
    masses = np.zeros(COORDINATE_COUNT)
    bodies = [(CAR_BODY, parameters.car_body)]
    bodies += [(index, parameters.bogie) for index in BOGIES]
    bodies += [(index, parameters.wheelset) for index in WHEELSETS]
    for index, group in bodies:
        start = coordinate(index, 0)
        masses[start : start + 3] = group.mass
        masses[start + ROLL] = group.roll_inertia
        masses[start + PITCH] = group.pitch_inertia
        masses[start + YAW] = group.yaw_inertia
    for wheelset in range(4):
        for side in range(2):
            masses[box_coordinate(wheelset, side)] = parameters.axle_box.pitch_inertia
    return np.diag(masses)


def gyroscopic_matrix(parameters: VehicleParameters, spin: float) -> Array:
    """Gyroscopic terms of the four wheelsets at the pitch rate ``spin`` in rad/s, (50, 50).

    The angular momentum ``I_wy * spin`` lies along the axle, which points
    to ``(-yaw, 1, roll)``; its change is the moment that roll and yaw need.
    """
    matrix = np.zeros((COORDINATE_COUNT, COORDINATE_COUNT))
    momentum = parameters.wheelset.pitch_inertia * spin
    for body in WHEELSETS:
        roll, yaw = coordinate(body, ROLL), coordinate(body, YAW)
        matrix[roll, yaw] = -momentum
        matrix[yaw, roll] = momentum
    return matrix


def nonlinear_directions(parameters: VehicleParameters, bodies: Bodies) -> Array:
    """Elongation of the eight non-linear elements per coordinate, shape (8, 50).

    Order: yaw dampers (bogie 1 left, right, bogie 2 left, right; along x),
    lateral dampers (bogie 1, 2; along y), lateral stops (bogie 1, 2; along y).
    Positive when the car body moves forward or right against the frame.
    """
    yaw, lateral = parameters.yaw_damper, parameters.lateral_damper
    rows = []
    for bogie in bodies.bogies:
        for sign in SIDE_SIGNS:
            point = np.array([bogie.position[0], sign * yaw.half_span, -yaw.height])
            rows.append(Element(upper=bodies.car_body, lower=bogie, point=point).deflection[0])
    for height in (lateral.height, parameters.lateral_bump_stop.height):
        for bogie in bodies.bogies:
            point = np.array([bogie.position[0], 0.0, -height])
            rows.append(Element(upper=bodies.car_body, lower=bogie, point=point).deflection[1])
    return np.array(rows)

"""All outputs of the vehicle: one table of names, units and meanings, and their rows.

Every output is linear in what the step's kernel returns (state, contact
forces, acceleration of the frame, internal forces), so the outputs are one
sparse matrix product. The first 44 are the motion of the four wheelsets in
the order of the FMI terminal, 11 each.
"""

# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
# pyright: reportUnknownVariableType=false, reportMissingTypeStubs=false
# (scipy.sparse is typed in part only.)

import dataclasses
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from rail_quantities import terminals
from scipy.sparse import csr_array

from rail_vehicle.arrangement import Bodies, linear_elements, wheelset_positions
from rail_vehicle.coordinates import (
    COORDINATE_COUNT,
    FREE,
    PITCH,
    ROLL,
    SIDES,
    SPINS,
    YAW,
    X,
    Y,
    Z,
)
from rail_vehicle.kernels import (
    PITCH_ANGLES,
    PITCH_RATES,
    POSITION,
    RESULT_COUNT,
    SPEED,
    VECTOR_COUNT,
)
from rail_vehicle.linear_system import FORCE_COUNT, FREE_COUNT, STATE_COUNT, FirstOrderSystem
from rail_vehicle.multibody import Array, Body, Element
from rail_vehicle.parameters import VehicleParameters

Output = terminals.Member
"""One output: dotted name, SI unit and meaning, as in the FMU."""

MOTION = terminals.MOTION
"""The motion of one wheelset, in the order of the terminal."""

MOTION_COUNT = len(MOTION)

_POSE = (
    (X, "longitudinal_displacement", "m", "Displacement forwards, against the car body"),
    (Y, "lateral_displacement", "m", "Displacement to the right"),
    (Z, "vertical_displacement", "m", "Displacement downwards from the datum"),
    (ROLL, "roll_angle", "rad", "Rotation about the line, positive with the right side down"),
    (PITCH, "pitch_angle", "rad", "Rotation about the lateral axis, positive with the front up"),
    (YAW, "yaw_angle", "rad", "Rotation about the vertical, positive turned to the right"),
)
_ACCELERATIONS = (
    (Y, "lateral_acceleration", "m/s2", "Acceleration to the right"),
    (Z, "vertical_acceleration", "m/s2", "Acceleration downwards, gravity not included"),
)


class _Rows:
    """Rows that give each coordinate, its rate and its acceleration from the kernel's result."""

    def __init__(self, system: FirstOrderSystem) -> None:
        self.coordinates = np.zeros((COORDINATE_COUNT, RESULT_COUNT))
        self.rates = np.zeros_like(self.coordinates)
        self.accelerations = np.zeros_like(self.coordinates)
        self.coordinates[FREE, np.arange(FREE_COUNT)] = 1.0
        self.coordinates[SPINS, PITCH_ANGLES + np.arange(4)] = 1.0
        self.rates[FREE, FREE_COUNT + np.arange(FREE_COUNT)] = 1.0
        self.rates[SPINS, PITCH_RATES + np.arange(4)] = 1.0
        inputs = np.column_stack(
            [system.force_input, system.acceleration_input, system.internal_input]
        )
        self.accelerations[FREE, :STATE_COUNT] = system.dynamics[FREE_COUNT:]
        self.accelerations[FREE, VECTOR_COUNT:] = inputs[FREE_COUNT:]

    @staticmethod
    def column(index: int) -> Array:
        """Row that gives entry ``index`` of the kernel's result."""
        row = np.zeros(RESULT_COUNT)
        row[index] = 1.0
        return row


_Entry = tuple[Output, Array, float]


@dataclasses.dataclass(frozen=True, kw_only=True)
class OutputMap:
    """Sparse rows and offsets of all outputs: ``y = offsets + rows @ result``."""

    table: tuple[Output, ...]
    offsets: Array
    values: Array
    columns: NDArray[np.int64]
    row_starts: NDArray[np.int64]


def make_output_map(
    parameters: VehicleParameters, bodies: Bodies, system: FirstOrderSystem
) -> OutputMap:
    """Build the rows of all outputs."""
    rows = _Rows(system)
    entries = list(_entries(parameters, bodies, rows))
    matrix = csr_array(np.array([row for _, row, _ in entries]))
    return OutputMap(
        table=tuple(output for output, _, _ in entries),
        offsets=np.array([offset for _, _, offset in entries]),
        values=np.asarray(matrix.data, dtype=np.float64),
        columns=matrix.indices.astype(np.int64),
        row_starts=matrix.indptr.astype(np.int64),
    )


def _entries(parameters: VehicleParameters, bodies: Bodies, rows: _Rows) -> Iterator[_Entry]:
    positions = wheelset_positions(parameters)
    for wheelset, position in zip(bodies.wheelsets, positions, strict=True):
        yield from _motion(wheelset, float(position), rows)
    for wheelset in bodies.wheelsets:
        output = Output(
            f"{wheelset.name}.pitch_angle", "rad", "Angle turned about the axle, negative forwards"
        )
        yield output, wheelset.motion[PITCH] @ rows.coordinates, 0.0
        yield from _accelerations(wheelset, rows)
    yield from _axle_boxes(parameters, bodies, rows)
    for bogie in bodies.bogies:
        yield from _pose(bogie, rows, first=X)
        yield from _accelerations(bogie, rows)
    car = bodies.car_body
    yield (
        Output("car_body.longitudinal_position", "m", "Position of the centre along the line"),
        (rows.column(POSITION)),
        0.0,
    )
    yield (
        Output("car_body.longitudinal_velocity", "m/s", "Running speed, forwards"),
        rows.column(SPEED),
        0.0,
    )
    yield from _pose(car, rows, first=Y)
    yield from _accelerations(car, rows)
    yield from _floor(parameters, car, rows)
    yield from _deflections(parameters, bodies, rows)
    yield from _damper_forces(rows)


def _motion(wheelset: Body, position: float, rows: _Rows) -> Iterator[_Entry]:
    motion = wheelset.motion
    shown = (X, Y, Z, ROLL, YAW)
    values = [motion[direction] @ rows.coordinates for direction in shown]
    values += [motion[direction] @ rows.rates for direction in (*shown, PITCH)]
    values[0] = values[0] + rows.column(POSITION)
    values[len(shown)] = values[len(shown)] + rows.column(SPEED)
    for index, (output, row) in enumerate(zip(MOTION, values, strict=True)):
        yield output._replace(name=f"{wheelset.name}.{output.name}"), row, position * (index == 0)


def _pose(body: Body, rows: _Rows, first: int) -> Iterator[_Entry]:
    for direction, name, unit, description in _POSE[first:]:
        row = body.motion[direction] @ rows.coordinates
        yield Output(f"{body.name}.{name}", unit, description), row, 0.0


def _accelerations(body: Body, rows: _Rows) -> Iterator[_Entry]:
    for direction, name, unit, description in _ACCELERATIONS:
        row = body.motion[direction] @ rows.accelerations
        yield Output(f"{body.name}.{name}", unit, description), row, 0.0


def _floor(parameters: VehicleParameters, car: Body, rows: _Rows) -> Iterator[_Entry]:
    """Accelerations of the floor over both bogies and at mid-car, where EN 12299 measures."""
    half, height = parameters.car_body.half_bogie_spacing, parameters.car_body.floor_height
    where = "floor over the leading bogie (1), at mid-car (2), over the trailing bogie (3)"
    for index, along in enumerate((half, 0.0, -half), start=1):
        motion = car.point_displacement(np.array([along, 0.0, -height]))
        for direction, name, unit, description in _ACCELERATIONS:
            output = Output(f"car_body_floor[{index}].{name}", unit, f"{description}; {where}")
            yield output, motion[direction] @ rows.accelerations, 0.0


def _axle_boxes(parameters: VehicleParameters, bodies: Bodies, rows: _Rows) -> Iterator[_Entry]:
    elements = linear_elements(parameters, bodies)
    mass = parameters.axle_box.mass
    for box in (box for pair in bodies.boxes for box in pair):
        yield from _accelerations(box, rows)
        output = Output(
            f"{box.name}.pitch_angle", "rad", "Rotation about the axle, positive with the front up"
        )
        yield output, box.motion[PITCH] @ rows.coordinates, 0.0
        load, row = _suspension_force(elements, box, rows)
        output = Output(
            f"{box.name}.journal_force", "N", "Vertical force of the box on the axle, downwards"
        )
        inertia = mass * (box.motion[Z] @ rows.accelerations)
        yield output, row - inertia, load + mass * parameters.gravity


def _suspension_force(elements: list[Element], box: Body, rows: _Rows) -> tuple[float, Array]:
    """Return static part and row of the primary suspension's downward force on a box."""
    load, row = 0.0, np.zeros(RESULT_COUNT)
    for element in elements:
        if element.lower.name == box.name:
            load -= element.preload[Z]
            deflection = element.deflection[Z]
            row += element.stiffness[Z] * (deflection @ rows.coordinates)
            row += element.damping[Z] * (deflection @ rows.rates)
    return float(load), row


def _deflections(parameters: VehicleParameters, bodies: Bodies, rows: _Rows) -> Iterator[_Entry]:
    meaning = "Compression at the axle box beyond the static one, positive if shorter"
    for index, pair in enumerate(bodies.boxes):
        frame = bodies.bogies[index // 2]
        for box, side in zip(pair, SIDES, strict=True):
            row = Element(upper=frame, lower=box, point=box.position).deflection[Z]
            name = f"primary_suspension[{index + 1}].{side}.vertical_deflection"
            yield Output(name, "m", meaning), row @ rows.coordinates, 0.0
    group = parameters.secondary_suspension
    for index, frame in enumerate(bodies.bogies):
        for sign, side in zip((-1.0, 1.0), SIDES, strict=True):
            point = np.array([frame.position[0], sign * group.half_span, -group.height])
            deflection = Element(upper=bodies.car_body, lower=frame, point=point).deflection
            name = f"secondary_suspension[{index + 1}].{side}"
            yield (
                Output(
                    f"{name}.vertical_deflection",
                    "m",
                    "Compression beyond the static one, positive if shorter",
                ),
                deflection[Z] @ rows.coordinates,
                0.0,
            )
            yield (
                Output(
                    f"{name}.lateral_deflection",
                    "m",
                    "Displacement of the car body against the frame, to the right",
                ),
                deflection[Y] @ rows.coordinates,
                0.0,
            )


def _damper_forces(rows: _Rows) -> Iterator[_Entry]:
    first = VECTOR_COUNT + FORCE_COUNT + 1
    names = [f"yaw_damper[{index}].{side}" for index in (1, 2) for side in SIDES]
    names += [f"lateral_damper[{index}]" for index in (1, 2)]
    names += [f"lateral_bump_stop[{index}]" for index in (1, 2)]
    for index, name in enumerate(names):
        direction = "rearwards" if name.startswith("yaw") else "to the left"
        meaning = f"Force on the car body, positive {direction}"
        yield Output(f"{name}.force", "N", meaning), rows.column(first + index), 0.0

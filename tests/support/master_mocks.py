"""Mock slaves for the master's tests: no FMU, a known answer, and a log of all calls."""

import copy

import numpy as np
from rail_cosim.errors import SlaveError
from rail_cosim.slave import Message, Status, Variable
from scipy.linalg import expm


def variable(name, causality="output", unit="", kind="real", start=0.0, **more):
    return Variable(name=name, causality=causality, unit=unit, kind=kind, start=start, **more)


class MockVector:
    def __init__(self, slave, names, kind):
        self.slave, self.names = slave, tuple(names)
        self.values = np.zeros(len(self.names), dtype=np.int32 if kind == "integer" else float)

    def place(self, buffer):
        self.values = buffer

    def read(self, count=None):
        count = len(self.names) if count is None else count
        if not self.names:
            return
        self.slave.log("read", count)
        self.slave.before_reading()
        self.values[:count] = [self.slave.data[name] for name in self.names[:count]]

    def write(self):
        self.slave.log("write")
        self.slave.data.update(zip(self.names, self.values.tolist(), strict=True))


class MockSlave:
    """Holds values by name; subclasses write ``advance``.

    ``fails_at`` is the number of the step (1, 2, ...) at which ``failure`` is raised.
    """

    def __init__(self, name, variables, *, calls=None, fails_at=None, failure=Status.DISCARD):
        self.name = name
        self.variables = {v.name: v for v in variables}
        self.data = {v.name: v.start for v in variables}
        self.memory = {}
        self.calls = [] if calls is None else calls
        self.fails_at, self.failure = fails_at, failure
        self.steps = 0
        self.warnings = []

    def log(self, *what):
        self.calls.append((self.name, *what))

    def vector(self, names, kind="real"):
        return MockVector(self, names, kind)

    def get(self, names):
        self.log("get", *names)
        return {name: self.data[name] for name in names}

    def set(self, values):
        self.log("set", *values)
        self.data.update(values)

    def setup(self, start_time, stop_time):
        self.log("setup", start_time, stop_time)

    def enter_initialization(self):
        self.log("enter_initialization")

    def exit_initialization(self):
        self.log("exit_initialization")

    def do_step(self, time, step_size):
        self.log("do_step", time, step_size)
        self.steps += 1
        if self.steps == self.fails_at:
            if isinstance(self.failure, BaseException):
                raise self.failure
            said = [Message(status=Status.ERROR, text="wheel 3 has left the rail")]
            raise SlaveError(self.name, "fmi2DoStep", self.failure, said, time)
        self.advance(time, step_size)

    def advance(self, time, step_size):
        pass

    def before_reading(self):
        pass

    def save_state(self):
        self.log("save_state")
        return copy.deepcopy((self.data, self.memory))

    def restore_state(self, state):
        self.log("restore_state")
        self.data, self.memory = copy.deepcopy(state)

    def free_state(self, state):
        self.log("free_state")

    def take_warnings(self):
        taken, self.warnings = self.warnings, []
        return taken


MASS, STIFFNESS, DAMPING = 900.0, 1.2e6, 6e4  # wheel on its suspension
RAIL_MASS, RAIL_STIFFNESS, RAIL_DAMPING = 100.0, 8e7, 9e4
CONTACT = 1.0e8
SPEED = 50.0
START = 1e-3  # the wheel is released from here
Z, V, F = (
    "wheelset[1].vertical_displacement",
    "wheelset[1].vertical_velocity",
    "wheelset[1].contact.vertical_force",
)


class Propagator:
    """Integrates x' = a x + b u exactly for u linear over a step."""

    def __init__(self, a, b):
        self.n, m = b.shape
        self.big = np.zeros((self.n + 2 * m, self.n + 2 * m))
        self.big[: self.n, : self.n], self.big[: self.n, self.n : self.n + m] = a, b
        self.big[self.n : self.n + m, self.n + m :] = np.eye(m)
        self.matrices = {}

    def __call__(self, state, start, end, step):
        if step not in self.matrices:
            self.matrices[step] = expm(self.big * step)[: self.n]
        return self.matrices[step] @ np.array([*state, start, (end - start) / step])


class MockVehicle(MockSlave):
    """A wheel on a spring; takes the contact force."""

    A = np.array([[0.0, 1.0], [-STIFFNESS / MASS, -DAMPING / MASS]])
    B = np.array([[0.0], [1.0 / MASS]])
    propagate = Propagator(A, B)

    def __init__(self, *, timed=True, extra=(), **more):
        variables = [
            variable("speed", "parameter", "m/s", start=SPEED, minimum=0.0),
            variable("static_wheel_load", "calculatedParameter", "N", start=69e3),
            variable("wheelset[1].initial_vertical_displacement", "parameter", "m"),
            variable(Z, unit="m", start=START),
            variable(V, unit="m/s"),
            variable("wheelset[1].longitudinal_position", unit="m", description="position"),
            variable("wheelset[1].longitudinal_velocity", unit="m/s", start=SPEED),
            variable(
                "axle_box[1].left.vertical_acceleration",
                unit="m/s2",
                description="acceleration of the axle box",
            ),
            variable(F, "input", "N"),
            *extra,
        ]
        if timed:
            variables.append(
                variable("coupling.input_time", "parameter", kind="string", start="step_start")
            )
        super().__init__("vehicle", variables, **more)

    def advance(self, time, step_size):
        now = self.data[F]
        before = self.memory.get("force", now)
        timing = self.data.get("coupling.input_time", "hold")
        start, end = {
            "step_start": (now, 2.0 * now - before),
            "step_end": (before, now),
            "hold": (now, now),
        }[timing]
        self.memory["force"] = now
        state = np.array([self.data[Z], self.data[V]])
        state = self.propagate(state, start, end, step_size)
        acceleration = float(self.A[1] @ state + end / MASS)
        self.data[Z], self.data[V] = map(float, state)
        self.data["axle_box[1].left.vertical_acceleration"] = acceleration
        self.data["wheelset[1].longitudinal_position"] = self.data["speed"] * (time + step_size)
        self.data["wheelset[1].longitudinal_velocity"] = self.data["speed"]

    def enter_initialization(self):
        super().enter_initialization()
        self.data["wheelset[1].longitudinal_velocity"] = self.data["speed"]

    def exit_initialization(self):
        super().exit_initialization()
        self.memory["force"] = self.data[F]


class MockTrack(MockSlave):
    """A rail mass on a spring with the contact spring; takes the wheel's motion."""

    A = np.array([[0.0, 1.0], [-(RAIL_STIFFNESS + CONTACT) / RAIL_MASS, -RAIL_DAMPING / RAIL_MASS]])
    B = np.array([[0.0], [CONTACT / RAIL_MASS]])
    propagate = Propagator(A, B)

    def __init__(self, *, timed=True, extra=(), **more):
        variables = [
            variable("static_wheel_load", "parameter", "N", start=1.0),
            variable(
                "fastener.vertical_stiffness",
                "parameter",
                "N/m",
                start=4e7,
                minimum=0.0,
                description="stiffness of one fastener",
            ),
            variable("fastener.spacing", "parameter", "m", start=0.629, minimum=0.1),
            variable("fastener.count_per_slab", "parameter", kind="integer", start=8),
            variable(F, unit="N"),
            variable("wheelset[1].left.normal_force", unit="N", description="normal force"),
            variable("wheelset[1].right.normal_force", unit="N", description="normal force"),
            variable("wheelset[1].static_vertical_displacement", unit="m", start=2e-5),
            variable("window.slide_count", kind="integer", start=0),
            variable(Z, "input", "m"),
            variable(V, "input", "m/s"),
            *extra,
        ]
        if timed:
            variables.append(
                variable("coupling.input_time", "parameter", kind="string", start="step_start")
            )
        super().__init__("track", variables, **more)
        self.memory["rail"] = np.zeros(2)

    def _publish(self, wheel):
        force = CONTACT * (wheel - self.memory["rail"][0])
        self.data[F] = -force
        self.data["wheelset[1].left.normal_force"] = 0.5 * force
        self.data["wheelset[1].right.normal_force"] = 0.5 * force

    def before_reading(self):
        if self.steps == 0:  # outputs follow the inputs during initialisation
            self._publish(self.data[Z])

    def exit_initialization(self):
        super().exit_initialization()
        self.memory["wheel"] = self.data[Z]

    def advance(self, time, step_size):
        wheel, before = self.data[Z], self.memory.get("wheel", self.data[Z])
        timing = self.data.get("coupling.input_time", "hold")
        start, end = {
            "step_start": (wheel, wheel + step_size * self.data[V]),
            "step_end": (before, wheel),
            "hold": (wheel, wheel),
        }[timing]
        self.memory["wheel"] = wheel
        self.memory["rail"] = self.propagate(self.memory["rail"], start, end, step_size)
        self._publish(end)
        self.data["window.slide_count"] = self.steps // 10


def monolithic(times):
    """Wheel displacement and contact force on the wheel of the same system, integrated whole."""
    a = np.zeros((4, 4))
    a[0, 1] = a[2, 3] = 1.0
    a[1] = np.array([-STIFFNESS - CONTACT, -DAMPING, CONTACT, 0.0]) / MASS
    a[3] = np.array([CONTACT, 0.0, -RAIL_STIFFNESS - CONTACT, -RAIL_DAMPING]) / RAIL_MASS
    states = np.array([expm(a * t) @ np.array([START, 0.0, 0.0, 0.0]) for t in times])
    return states[:, 0], -CONTACT * (states[:, 0] - states[:, 2])

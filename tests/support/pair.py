"""Couple the two cores without FMI: a monolithic reference, and the single wheelset for tests.

In :func:`run_monolithic` both cores take the same small step and the motion at its
end is iterated until it no longer changes: one implicit integration of all equations.
"""

import dataclasses
import itertools

import numpy as np
from force_memory import ForceMemory
from rail_vehicle import VehicleModel
from rail_vehicle.coupling import ForceHistory
from slab_track import TrackModel


@dataclasses.dataclass(frozen=True)
class History:
    """Histories of a run; forces and penetrations left first."""

    time: np.ndarray  # (time,)
    position: np.ndarray  # (time, wheelset)
    normal_force: np.ndarray  # (time, wheelset, side)
    acceleration: np.ndarray  # (time, wheelset), vertical
    height: np.ndarray  # (time, wheelset)
    slide_count: np.ndarray  # (time,)


class SingleWheelset:
    """A wheelset under its constant share of the weight, with the interface of VehicleModel."""

    def __init__(self, *, mass: float, load: float, speed: float) -> None:
        self.mass, self.load, self.speed = mass, load, speed

    def initial_state(self, heights: np.ndarray) -> np.ndarray:
        state = np.zeros(4)  # x, z, vz, az
        state[1] = heights[0]
        return state

    def motion(self, state: np.ndarray) -> np.ndarray:
        row = np.zeros((1, 11))
        row[0, [0, 2, 5, 7]] = state[0], state[1], self.speed, state[2]
        return row

    def step(self, state, start, end, dt, _speed=None, bow=None):
        """Integrate exactly a force that is a parabola in time."""
        a0, a1 = ((2.0 * self.load + f[0, 2]) / self.mass for f in (start, end))
        b = 0.0 if bow is None else bow[0, 2] / self.mass
        x, z, v, _ = state
        new = np.array(
            [
                x + self.speed * dt,
                z + dt * v + dt**2 * (a0 / 3 + a1 / 6 - b / 12),
                v + dt * (0.5 * (a0 + a1) - b / 6),
                a1,
            ]
        )
        return new, new


class WholeVehicle:
    """VehicleModel with the few names that the loops below use."""

    def __init__(self, model: VehicleModel) -> None:
        self.model = model
        self.static = model.static_forces

    def initial_state(self, heights):
        return self.model.initial_state(heights)

    def motion(self, state):
        return self.model.outputs(state, self.static).motion.copy()

    def step(self, *arguments):
        return self.model.step(*arguments)


def _begin(track: TrackModel, vehicle):
    count = track.parameters.wheelset_count
    state = vehicle.initial_state(np.zeros(count))
    rest = track.initial_state(vehicle.motion(state))
    state = vehicle.initial_state(rest.static_heights)
    return track.with_motion(rest, vehicle.motion(state)), state


def _record(rows, time, motion, track_state, acceleration):
    rows.append(
        (
            time,
            motion[:, 0].copy(),
            track_state.normal_force.copy(),
            acceleration,
            motion[:, 2].copy(),
            track_state.slide_count,
        )
    )


def _acceleration(vehicle, outputs, count):
    if isinstance(vehicle, SingleWheelset):
        return np.array([outputs[3]])
    return np.array(
        [
            0.5
            * sum(
                outputs[f"axle_box[{i + 1}].{side}.vertical_acceleration"]
                for side in ("left", "right")
            )
            for i in range(count)
        ]
    )


def run_monolithic(track: TrackModel, vehicle, *, distance: float, speed: float, step: float):
    """Run track and vehicle as one system with the step given, s; return a History."""
    count = track.parameters.wheelset_count
    track_state, state = _begin(track, vehicle)
    forces = track.outputs(track_state).contact
    rows: list = []
    for n in range(1, round(distance / speed / step) + 1):
        guess = forces
        for _ in range(20):
            new_state, outputs = vehicle.step(state, forces, guess, step)
            motion = vehicle.motion(new_state)
            new_track, answer = track.step(track_state, motion, step, at_end=True)
            change = np.max(np.abs(answer.contact - guess))
            guess = answer.contact
            if change < 1e-6:
                break
        else:
            raise RuntimeError(f"no convergence at t = {n * step:g} s: {change:g} N")
        state, track_state, forces = new_state, new_track, guess
        _record(rows, n * step, motion, track_state, _acceleration(vehicle, outputs, count))
    return History(*(np.array(column) for column in zip(*rows, strict=True)))


def run_staggered(
    track: TrackModel, vehicle, *, distance: float, speed: float, step, jacobi: bool = False
):
    """Run as the master does: Gauss-Seidel with the track first, or Jacobi.

    ``step``, s, or several that follow one another in turn.
    """
    steps = itertools.cycle(np.atleast_1d(step).tolist())
    count = track.parameters.wheelset_count
    track_state, state = _begin(track, vehicle)
    motion, forces = vehicle.motion(state), track.outputs(track_state).contact
    memory, last, time = ForceMemory(ForceHistory.begin(forces)), 0.0, 0.0
    rows: list = []
    while time < distance / speed * (1.0 - 1e-9):
        step = next(steps)
        track_state, answer = track.step(track_state, motion, step)
        given, elapsed = (forces, last) if jacobi else (answer.contact, step)
        curve = memory.take(given.ravel(), elapsed, step, 2, at_end=not jacobi)
        start, end, quadratic = curve.reshape(3, -1, 6)
        state, outputs = vehicle.step(state, start, end, step, None, quadratic)
        motion, forces, last, time = vehicle.motion(state), answer.contact, step, time + step
        _record(rows, time, motion, track_state, _acceleration(vehicle, outputs, count))
    return History(*(np.array(column) for column in zip(*rows, strict=True)))

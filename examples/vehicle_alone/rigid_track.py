"""The vehicle FMU on a track of one's own: rigid rails with a smooth bump, and springs as contact.

Vertical motion only: each wheelset rests on its rails by a spring, under which the rails sink by
``DEPTH`` on a way of ``LENGTH`` and stay down. What is known in advance: before, all is at rest;
long after, every body is ``DEPTH`` lower, on all its springs unchanged.
"""

import sys
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from numpy.typing import NDArray

STIFFNESS, DAMPING = 2.0e9, 2.0e4  # N/m and N.s/m, both wheels of a wheelset
DEPTH, LENGTH, BEGIN = 5e-3, 20.0, 30.0  # m
SPEED = 300.0 / 3.6  # m/s
STEP = 1e-4  # s
BODIES = ["car_body", "bogie[1]", "bogie[2]", *(f"wheelset[{i}]" for i in (1, 2, 3, 4))]


def rail_height(position: NDArray) -> NDArray:
    """Return how far the rails lie down at positions on the line, m."""
    share = np.clip((position - BEGIN) / LENGTH, 0.0, 1.0)
    return 0.5 * DEPTH * (1.0 - np.cos(np.pi * share))


def run(path: Path, duration: float) -> tuple[NDArray, NDArray]:
    """Run the vehicle on these rails; return times (n,) and the bodies' heights (n, 7), m."""
    about = fmpy.read_model_description(str(path))
    number = {v.name: v.valueReference for v in about.modelVariables}
    terminals = [f"wheelset[{i}]." for i in (1, 2, 3, 4)]
    force = [number[f"{t}contact.vertical_force"] for t in terminals]
    place = [number[f"{t}longitudinal_position"] for t in terminals]
    height = [number[f"{t}vertical_displacement"] for t in terminals]
    rate = [number[f"{t}vertical_velocity"] for t in terminals]
    bodies = [number[f"{body}.vertical_displacement"] for body in BODIES]
    fmu = FMU2Slave(
        guid=about.guid,
        unzipDirectory=fmpy.extract(str(path)),
        modelIdentifier=about.coSimulation.modelIdentifier,
        instanceName="vehicle",
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    weight = -np.array(fmu.getReal(force))  # the inputs start as minus the axle loads
    rows = [fmu.getReal(bodies)]
    times = np.arange(round(duration / STEP) + 1) * STEP
    for time in times[:-1]:
        x, z, v = (np.array(fmu.getReal(r)) for r in (place, height, rate))
        slope = (rail_height(x + 1e-3) - rail_height(x - 1e-3)) / 2e-3
        # No tension: a wheel that lifts off is free.
        pressed = weight + STIFFNESS * (z - rail_height(x)) + DAMPING * (v - SPEED * slope)
        fmu.setReal(force, (-np.maximum(pressed, 0.0)).tolist())
        fmu.doStep(time, STEP)
        rows.append(fmu.getReal(bodies))
    fmu.terminate()
    fmu.freeInstance()
    return times, np.array(rows)


if __name__ == "__main__":
    times, heights = run(Path(sys.argv[1]), 6.0)
    for body, before, after in zip(BODIES, heights[3000], heights[-1], strict=True):
        print(f"{body}: {1e3 * before:.6f} mm before, {1e3 * after:.6f} mm after")

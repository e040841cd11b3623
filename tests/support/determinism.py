"""Ways of doing the same that must give the same bits; called in a process of its own.

Each function takes and returns plain values (see :meth:`product.Product.call`).
"""

from pathlib import Path
from typing import Any

import numpy as np
import rail_cosim
from fmu_probes import STEP, Driver

COUNT, SAVED_AT = 60, 31
_CHUNKS = (1, 2, 17, 11, 29)


def runs(cases: list[dict[str, Any]]) -> list[dict[str, np.ndarray]]:
    """Run vehicle and track for each case, one after the other; return all variables."""
    found = []
    for case in cases:
        dataset = rail_cosim.run(**case)
        found.append({str(name): dataset[name].to_numpy() for name in dataset.variables})
    return found


def ways_to_step(path: Path, parameters: dict[str, Any]) -> dict[str, np.ndarray]:
    """Return the outputs of instances that all do the same steps, each in its own way.

    They live at the same time; the reference goes first and on to the end.
    """
    whole = _driver(path, "whole").begin(**parameters)
    found = {"whole": whole.run(0, COUNT)}
    drivers = {name: _driver(path, name).begin(**parameters) for name in ("chunks", "in turn")}
    found["chunks"] = _in_chunks(drivers["chunks"])
    other = Driver(path, "another phase", phase=1.3).begin(**parameters)
    found["in turn"] = np.concatenate([(drivers["in turn"].run(step, 1), other.run(step, 1))[0]
                                       for step in range(COUNT)])  # fmt: skip
    drivers["unread"] = _driver(path, "unread").begin(**parameters)
    found["unread"] = _unread(drivers["unread"])
    for driver in (whole, other, *drivers.values()):
        driver.host.close()
    return found


def _driver(path: Path, name: str) -> Driver:
    return Driver(path, f"{path.stem} {name}")


def _in_chunks(driver: Driver) -> np.ndarray:
    """Rest between chunks of steps: read everything, save the state, set inputs to and fro."""
    host, rows, step = driver.host, [], 0
    references = [v.valueReference for v in driver.inputs]
    for chunk in _CHUNKS:
        rows.append(driver.run(step, chunk))
        step += chunk
        for variable in host.vars:
            host.get(variable)
        state = host.fmu.getFMUstate()
        host.fmu.serializeFMUstate(state)
        host.fmu.freeFMUstate(state)
        values = host.fmu.getReal(references)
        host.fmu.setReal(references, [0.5 * value for value in values])
        host.fmu.getReal(driver.outputs)
        host.fmu.setReal(references, values)
    assert step == COUNT
    return np.concatenate(rows)


def _unread(driver: Driver) -> np.ndarray:
    """Read outputs after the last step only."""
    for step in range(COUNT):
        driver._set(step)
        driver.host.fmu.doStep(step * STEP, STEP)
    return np.array([driver.host.fmu.getReal(driver.outputs)])


def ways_to_restore(
    path: Path, parameters: dict[str, Any], others: dict[str, Any]
) -> dict[str, np.ndarray]:
    """Return the outputs after a saved state, restored in several ways, and those without.

    ``others`` are parameters of an instance that ran before it takes the state.
    """
    first = _driver(path, "first").begin(**parameters)
    first.run(0, SAVED_AT)
    state = first.host.fmu.getFMUstate()
    data = first.host.fmu.serializeFMUstate(state)
    rest = COUNT - SAVED_AT
    found = {"went on": first.run(SAVED_AT, rest)}
    used = _driver(path, "used").begin(**others)
    used.run(0, 5)
    new = _driver(path, "new")
    for name, driver in (("other instance", used), ("new instance", new)):
        fmu = driver.host.fmu
        fmu.setFMUstate(fmu.deSerializeFMUstate(data))
        found[name] = driver.run(SAVED_AT, rest)
    fmu = first.host.fmu
    fmu.setFMUstate(state)
    found["in memory"] = first.run(SAVED_AT, rest)
    copy = fmu.deSerializeFMUstate(data)
    fmu.setFMUstate(copy)
    found["serialised"] = first.run(SAVED_AT, rest)
    first.host.fmu.freeFMUstate(state)
    for driver in (first, used, new):
        driver.host.close()
    return found


def ways_to_begin(path: Path, parameters: dict[str, Any], count: int) -> dict[str, np.ndarray]:
    """Return the outputs after orders of set-up calls that FMI allows."""
    turned = dict(reversed(parameters.items()))
    orders = {
        "parameters first": ["all", "setup", "enter", "inputs", "exit"],
        "after the experiment": ["setup", "all", "enter", "inputs", "exit"],
        "in initialization": ["setup", "enter", "all", "inputs", "exit"],
        "inputs first": ["inputs", "setup", "enter", "all", "exit"],
        "other order": ["setup", "turned", "enter", "inputs", "exit"],
        "one by one, read between": ["setup", "enter", "read", "one by one", "inputs", "exit"],
        "after a reset": [
            "setup", "enter", "inputs", "exit", "step", "reset", "all", "setup", "enter", "inputs",
            "exit",
        ],
    }  # fmt: skip
    found = {}
    for order, names in orders.items():
        driver = _driver(path, order)
        host, fmu = driver.host, driver.host.fmu
        calls = {
            "all": lambda host=host: host.set(**parameters),
            "turned": lambda host=host: host.set(**turned),
            "one by one": lambda host=host: _one_by_one(host, parameters),
            "read": lambda driver=driver: driver.host.fmu.getReal(driver.outputs),
            "inputs": lambda driver=driver: driver._set(0),
            "setup": lambda fmu=fmu: fmu.setupExperiment(startTime=0.0),
            "enter": fmu.enterInitializationMode,
            "exit": fmu.exitInitializationMode,
            "step": lambda driver=driver: driver.run(0, 3),
            "reset": fmu.reset,
        }
        for name in names:
            calls[name]()
        found[order] = driver.run(0, count)
        host.close()
    return found


def _one_by_one(host: Any, parameters: dict[str, Any]) -> None:
    for name, value in parameters.items():
        host.set(**{name: value})
        host.get(name)

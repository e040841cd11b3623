"""The vehicle FMU without a track, in ``fmpy.simulate_fmu``."""

from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np
import pytest
from fmu_probes import WHEEL_RADIUS, simulate

COUNT, INTERVAL = 1000, 1e-3
MOVING = ("longitudinal_position", "pitch_angle")
"""Outputs that grow with the way."""


def preset(path, name):
    """Return the real parameters of a named vehicle."""
    with ZipFile(path) as archive:
        root = ElementTree.fromstring(archive.read(f"resources/presets/{name}.ssv"))
    return {p.get("name"): float(p[0].get("value")) for p in root[0] if p[0].tag.endswith("Real")}


@pytest.mark.parametrize("name", ["paper", "manchester1"])
def test_constant_contact_forces_keep_it_in_equilibrium(fmus, name):
    """The vertical contact forces start as minus the axle loads of the vehicle chosen."""
    values = preset(fmus.vehicle, name)
    result = fmus.call(simulate, fmus.vehicle, INTERVAL, COUNT, start_values=values)
    still = [n for n in result.dtype.names if n != "time" and not n.endswith(MOVING)]
    displacements = [n for n in still if n.endswith(("displacement", "deflection", "angle"))]
    assert len(displacements) > 40
    for output in displacements:
        assert np.abs(result[output]).max() < 1e-9, output
    for output in still:
        if output.endswith("vertical_acceleration"):
            assert np.abs(result[output]).max() < 1e-8, output


def test_it_runs_on_at_its_speed_and_rolls(fmus):
    speed = 50.0
    values = {"speed": speed, "initial_position": 1000.0}
    result = fmus.call(simulate, fmus.vehicle, INTERVAL, COUNT, start_values=values)
    way = 1000.0 + speed * result["time"]
    for number, behind in enumerate((0.0, 2.5, 17.8, 20.3), start=1):
        place = result[f"wheelset[{number}].longitudinal_position"]
        assert place == pytest.approx(way - behind, abs=1e-9)
        spin = result[f"wheelset[{number}].pitch_rate"]
        assert spin == pytest.approx(-speed / WHEEL_RADIUS, rel=1e-12)


def test_a_force_step_accelerates_its_wheelset(fmus):
    """Just after 1 kN more on wheelset 2 it has the acceleration 1 kN / mass, downwards."""
    force = "wheelset[2].contact.vertical_force"
    inputs = np.zeros(2, dtype=[("time", float), (force, float)])
    inputs["time"] = 0.0, 1.0
    inputs[force] = -2.0 * 44039.0 / 8 * 9.81 - 2439.0 / 2 * 9.81 - 1881.0 * 9.81 + 1e3
    result = fmus.call(simulate, fmus.vehicle, 1e-4, 10, input=inputs)
    speed = result["wheelset[2].vertical_velocity"]
    # 1 ms: the primary suspension (9 MN/m on either side) takes some of it away.
    assert speed[-1] == pytest.approx(1e3 / 1881.0 * 1e-3, rel=0.03)
    assert np.abs(result["wheelset[1].vertical_velocity"]).max() < 0.01 * speed[-1]

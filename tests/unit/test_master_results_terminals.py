"""Records of a track with more terminals than the vehicle has wheelsets."""

import numpy as np
from master_mocks import MockSlave, variable
from rail_cosim.recorder import Recorder
from rail_cosim.results import to_dataset
from rail_cosim.system import SystemStructure


def test_terminals_that_nothing_is_connected_to_are_left_out():
    height, force = "wheelset[{}].vertical_displacement", "wheelset[{}].contact.vertical_force"
    vehicle = MockSlave(
        "vehicle", [variable(height.format(1), unit="m"), variable(force.format(1), "input", "N")]
    )
    track = MockSlave(
        "track",
        [
            *(variable(height.format(i), "input", "m") for i in (1, 2, 3, 4)),
            *(variable(force.format(i), unit="N", start=float(i)) for i in (1, 2, 3, 4)),
            *(variable(f"wheelset[{i}].left.normal_force", unit="N") for i in (1, 2, 3, 4)),
        ],
    )
    system = SystemStructure([track, vehicle])
    for port in system.ports:
        port.read_all()
    recorder = Recorder(system.ports)
    recorder.record(0.0)
    data = to_dataset(system, recorder, {})
    assert data.sizes["wheelset"] == 1
    assert data["normal_force"].shape == (1, 1, 2)
    assert np.array_equal(data["wheelset_contact_vertical_force"], [[1.0]])

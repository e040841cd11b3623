"""Names, units and values of the outputs, each against kinematics by hand."""

import numpy as np
import pytest
from rail_vehicle import PAPER, VehicleModel, VehicleState
from rail_vehicle.outputs import MOTION
from vehicle_reference import state_with


@pytest.fixture(scope="module")
def model():
    return VehicleModel(PAPER)


def moved(model, **entries):
    """Return the outputs at some coordinates (``q8=...``) and rates (``v8=...``)."""
    q, v = np.zeros(50), np.zeros(50)
    for name, value in entries.items():
        (q if name[0] == "q" else v)[int(name[1:])] = value
    return model.outputs(state_with(model, q, v), model.static_forces)


def test_terminal_is_first_and_in_order(model):
    names = [output.name for output in model.output_table]
    expected = [f"wheelset[{i}].{output.name}" for i in (1, 2, 3, 4) for output in MOTION]
    assert names[:44] == expected
    assert [output.name for output in MOTION] == [
        "longitudinal_position",
        "lateral_displacement",
        "vertical_displacement",
        "roll_angle",
        "yaw_angle",
        "longitudinal_velocity",
        "lateral_velocity",
        "vertical_velocity",
        "roll_rate",
        "yaw_rate",
        "pitch_rate",
    ]


def test_names_are_unique_and_described(model):
    names = [output.name for output in model.output_table]
    assert len(set(names)) == len(names)
    assert all(output.unit and output.description for output in model.output_table)


def test_wheelsets_stand_behind_the_leading_one():
    shifted = VehicleModel(PAPER.replace(initial_position=100.0))
    motion = shifted.outputs(shifted.initial_state(), shifted.static_forces).motion
    assert motion[:, 0] == pytest.approx([100.0, 97.5, 82.2, 79.7])
    assert motion[:, 5] == pytest.approx(300.0 / 3.6)
    assert motion[:, 10] == pytest.approx(-300.0 / 3.6 / 0.46)
    assert not motion[:, 1:5].any()


@pytest.mark.parametrize("wheelset", range(4))
def test_motion_shows_each_coordinate_in_its_column(model, wheelset):
    start = 18 + 6 * wheelset
    entries = {f"q{start + k}": 1e-3 * (k + 1) for k in (0, 1, 2, 3, 5)}
    entries |= {f"v{start + k}": 1e-2 * (k + 1) for k in (0, 1, 2, 3, 5)}
    motion = moved(model, **entries).motion[wheelset]
    rest = moved(model).motion[wheelset]
    assert motion - rest == pytest.approx(
        [1e-3, 2e-3, 3e-3, 4e-3, 6e-3, 1e-2, 2e-2, 3e-2, 4e-2, 6e-2, 0.0], abs=1e-12
    )


def test_axle_box_feels_the_wheelsets_roll(model):
    """Only moments about x on a free wheelset: its boxes accelerate against each other."""
    forces = model.static_forces
    forces[0, 3] = 923.0
    outputs = model.outputs(model.initial_state(), forces)
    assert outputs["axle_box[1].right.vertical_acceleration"] == pytest.approx(1.0)
    assert outputs["axle_box[1].left.vertical_acceleration"] == pytest.approx(-1.0)
    forces[0, 2] += 1881.0 * 2.0
    outputs = model.outputs(model.initial_state(), forces)
    assert outputs["axle_box[1].right.vertical_acceleration"] == pytest.approx(3.0)
    assert outputs["wheelset[1].vertical_acceleration"] == pytest.approx(2.0)
    assert outputs["axle_box[2].right.vertical_acceleration"] == 0.0
    static = (44039.0 + 2 * 2439.0) / 8.0 * 9.81
    journal = outputs["axle_box[1].right.journal_force"]
    assert journal == pytest.approx(static + 84.0 * (9.81 - 3.0))


def test_deflections_are_compressions(model):
    outputs = moved(model, q8=1e-3, q9=2e-3, q10=-4e-3)
    # Frame of bogie 1: down 1 mm, right side down by roll, front down by negative pitch.
    expected = {"left": 1e-3 + 1.25 * 4e-3 - 2e-3, "right": 1e-3 + 1.25 * 4e-3 + 2e-3}
    for side, value in expected.items():
        name = f"primary_suspension[1].{side}.vertical_deflection"
        assert outputs[name] == pytest.approx(value)
    name = "primary_suspension[2].right.vertical_deflection"
    assert outputs[name] == pytest.approx(1e-3 - 1.25 * 4e-3 + 2e-3)
    name = "secondary_suspension[1].right.vertical_deflection"
    assert outputs[name] == pytest.approx(-1e-3 - 1.23 * 2e-3)
    assert outputs["secondary_suspension[2].left.vertical_deflection"] == 0.0


def test_secondary_deflection_feels_roll_at_its_height(model):
    outputs = moved(model, q1=5e-3, q3=2e-3)
    # The car body's roll to the right moves what is below its centre to the left.
    expected = 5e-3 - (1.71 - 0.76) * 2e-3
    name = "secondary_suspension[2].right.lateral_deflection"
    assert outputs[name] == pytest.approx(expected)
    name = "secondary_suspension[2].right.vertical_deflection"
    assert outputs[name] == pytest.approx(1.23 * 2e-3)


def test_body_coordinates_are_shown_under_their_names(model):
    names = ["lateral_displacement", "vertical_displacement", "roll_angle", "pitch_angle"]
    outputs = moved(model, **{f"q{k}": 1e-3 * k for k in (*range(1, 6), *range(6, 18), 44)})
    for k, name in enumerate([*names, "yaw_angle"], start=1):
        assert outputs[f"car_body.{name}"] == pytest.approx(1e-3 * k)
        assert outputs[f"bogie[1].{name}"] == pytest.approx(1e-3 * (6 + k))
        assert outputs[f"bogie[2].{name}"] == pytest.approx(1e-3 * (12 + k))
    assert outputs["bogie[2].longitudinal_displacement"] == pytest.approx(12e-3)
    assert outputs["axle_box[2].left.pitch_angle"] == pytest.approx(44e-3)


def test_accelerations_agree_with_the_change_of_velocity(model):
    rng = np.random.default_rng(5)
    state = state_with(model, rng.normal(size=50) * 1e-4, rng.normal(size=50) * 1e-3)
    forces = model.static_forces + rng.normal(size=(4, 6)) * 1e2
    dt = 1e-6
    later, outputs = model.step(state, forces, forces, dt)
    change = (later.rates - state.rates) / dt
    for name, index in (("car_body", 0), ("bogie[1]", 6), ("bogie[2]", 12), ("wheelset[3]", 30)):
        for direction, offset in (("lateral", 1), ("vertical", 2)):
            found = outputs[f"{name}.{direction}_acceleration"]
            assert found == pytest.approx(change[index + offset], rel=1e-3, abs=1e-5)


def test_floor_moves_with_the_car_body(model):
    """A moment about one axis turns the body: each place of the floor by its own lever."""
    start = model.initial_state()
    rest = model.outputs(start, model.static_forces)
    q = np.zeros(50)
    q[[3, 4, 5]] = 2e-3, -1e-3, 3e-3  # roll, pitch, yaw of the car body strain the suspension
    outputs = model.outputs(state_with(model, q, np.zeros(50)), model.static_forces)
    dt = 1e-6
    state = state_with(model, q, np.zeros(50))
    later, _ = model.step(state, model.static_forces, model.static_forces, dt)
    _, lateral, vertical, roll, pitch, yaw = (later.rates[:6] - state.rates[:6]) / dt
    below = 1.71 - 1.25
    for place, along in ((1, 8.9), (2, 0.0), (3, -8.9)):
        found = outputs[f"car_body_floor[{place}].vertical_acceleration"]
        assert found == pytest.approx(vertical - pitch * along, rel=1e-3)
        found = outputs[f"car_body_floor[{place}].lateral_acceleration"]
        assert found == pytest.approx(lateral + yaw * along - roll * below, rel=1e-3)
        assert rest[f"car_body_floor[{place}].vertical_acceleration"] == pytest.approx(0, abs=1e-9)


def test_state_that_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="104 finite entries"):
        VehicleState.of_vector(np.zeros(7))
    with pytest.raises(ValueError, match="104 finite entries"):
        VehicleState.of_vector(np.full(104, np.nan))

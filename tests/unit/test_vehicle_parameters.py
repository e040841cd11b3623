"""Parameters of the vehicle: names, defaults, checks, presets."""

import pytest
from rail_quantities import ParameterError, UnknownParameterError, flatten, with_values
from rail_vehicle import MANCHESTER_1, PAPER, SOFT_PRIMARY, VehicleModel, VehicleParameters

TABLE_2 = {
    "car_body.mass": 44039.0,
    "bogie.mass": 2439.0,
    "wheelset.mass": 1881.0,
    "bogie.pitch_inertia": 1846.0,
    "secondary_suspension.vertical_stiffness": 0.24e6,
    "secondary_suspension.vertical_damping": 25e3,
    "primary_suspension.vertical_stiffness": 9e6,
    "primary_suspension.vertical_damping": 10.5e3,
    "wheelset.radius": 0.46,
    "car_body.half_bogie_spacing": 8.9,
    "bogie.half_wheelbase": 1.25,
}


def test_defaults_are_table_2():
    values = {name: value for name, (_, value) in flatten(VehicleParameters()).items()}
    assert {name: values[name] for name in TABLE_2} == TABLE_2
    assert values["speed"] == pytest.approx(300.0 / 3.6)


def test_every_parameter_is_described():
    for name, (about, _) in flatten(PAPER).items():
        assert about.description, name
        assert about.unit != "1", name
    run_settings = ("speed", "initial_position", "initial_lateral_displacement", "gravity")
    sources = {n: a.source for n, (a, _) in flatten(PAPER).items() if n not in run_settings}
    assert all(sources.values()), [name for name, source in sources.items() if not source]


@pytest.mark.parametrize(
    "name", [n for n, (a, v) in flatten(PAPER).items() if isinstance(v, float)]
)
def test_every_parameter_matters(name):
    """Half or twice of any parameter changes the model (or is one of the run's settings)."""
    value = flatten(PAPER)[name][1]
    # A damper may not stiffen when it blows off, so these are lowered.
    factor = 0.5 if name.endswith(("blow_off_damping", "half_wheelbase")) else 1.7
    other = 1.0 if "displacement" in name else 1.0e3  # in place of zero
    changed = with_values(PAPER, {name: value * factor if value else other})
    assert _fingerprint(changed) != _fingerprint(PAPER)


def _fingerprint(parameters):
    model = VehicleModel(parameters)
    state = model.initial_state()
    vector = state.vector.copy()
    vector[45:90] = 0.3
    vector[:45] += 0.04
    forces = model.static_forces
    state = type(state).of_vector(vector)
    outputs = []
    for _ in range(3):
        state, now = model.step(state, forces, forces, 1e-2, 100.0)
        outputs.append(now.vector)
    return [row.tobytes() for row in outputs]


@pytest.mark.parametrize(
    ("name", "value", "limit"),
    [
        ("primary_suspension.vertical_stiffness", -1.0, "greater than 0"),
        ("wheelset.mass", 0.0, "greater than 0"),
        ("yaw_damper.damping", -1.0, "at least 0"),
        ("yaw_damper.blow_off_damping", 4e5, "at most yaw_damper.damping"),
        ("lateral_damper.blow_off_damping", 4e5, "at most lateral_damper.damping"),
        ("bogie.half_wheelbase", 9.0, "half_bogie_spacing"),
        ("axle_box.mass", 1000.0, "wheelset.mass"),
        ("car_body.mass", float("nan"), "finite"),
    ],
)
def test_impossible_value_is_refused_by_name(name, value, limit):
    with pytest.raises(ParameterError, match=limit) as caught:
        with_values(PAPER, {name: value})
    assert caught.value.name == name
    assert str(caught.value).startswith(name)


def test_misspelt_name_gets_the_nearest():
    with pytest.raises(UnknownParameterError, match=r"primary_suspension\.vertical_stiffness"):
        with_values(PAPER, {"primary_suspension.vertical_stifness": 1.0})


def test_presets():
    assert VehicleParameters() == PAPER
    assert SOFT_PRIMARY.primary_suspension.vertical_stiffness == pytest.approx(0.9e6)
    weight = (32000.0 + 2 * 2615.0 + 4 * 1813.0) * 9.81
    assert MANCHESTER_1.static_wheel_load == pytest.approx(weight / 8.0)
    assert MANCHESTER_1.yaw_damper.damping == 0.0

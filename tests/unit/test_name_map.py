"""Foreign names, signs and units: what a name map makes of a description."""

import pytest
from described_fmus import FORCES, MOTION, fmu, vehicle
from rail_cosim.check import check_fmu
from rail_cosim.errors import ParameterError, UnknownNameError
from rail_cosim.name_map import described, read_name_map, renamed
from rail_cosim.slave import Renaming, Variable
from rail_cosim.trial import trial_findings

HEIGHT = "wheelset[1].vertical_displacement"


def own_names(count=2):
    """Return a vehicle whose terminals are called ws1_yaw_rate, ws1_contact_yaw_moment, ..."""
    return {
        name.replace("wheelset[", "ws").replace("].", "_").replace(".", "_"): about
        for name, about in vehicle(count).items()
    }


NAMES = {f"wheelset[{{i}}].{n}": f"ws{{i}}_{n.replace('.', '_')}" for n in (*MOTION, *FORCES)}


def toml(folder, names=NAMES, **more):
    lines = [f'"{name}" = "{own}"' for name, own in names.items()]
    lines += [f'"{name}" = {text}' for name, text in more.items()]
    path = folder / "names.toml"
    path.write_text("\n".join(["[names]", *lines]), encoding="utf-8")
    return path


def test_names_are_those_of_the_contract_for_as_many_wheelsets_as_there_are(tmp_path):
    foreign = fmu(tmp_path / "Foreign.fmu", own_names(2))
    assert check_fmu(foreign).role is None
    report = check_fmu(foreign, names=toml(tmp_path))
    assert (report.role, report.wheelsets, report.faults) == ("vehicle", 2, [])
    assert list(report.description.variables) == list(vehicle(2))  # in the FMU's order


def test_unit_sign_limits_and_start_follow_the_conversion(tmp_path):
    variables = own_names(1) | {
        "ws1_vertical_displacement": ("output", "mm"),
        "v0": ("parameter", "km/h", "36"),
    }
    limits = 'unit="km/h" start="36"', 'unit="km/h" min="-72" max="360" start="36"'
    foreign = fmu(
        tmp_path / "Foreign.fmu",
        variables,
        edit=lambda text: text.replace(*limits),
    )
    plain = NAMES | {"speed": "v0"}
    faults = {f.subject: f.text for f in check_fmu(foreign, names=toml(tmp_path, plain)).faults}
    assert faults[HEIGHT] == "is in mm; must be in m"
    assert faults["speed"] == "is in km/h; must be in m/s"
    names = toml(
        tmp_path,
        {k: v for k, v in NAMES.items() if "vertical_displacement" not in k},
        **{
            HEIGHT: '{ name = "ws1_vertical_displacement", factor = -1e-3, offset = 0.01 }',
            "speed": '{ name = "v0", factor = -0.2777777777777778 }',
        },
    )
    report = check_fmu(foreign, names=names)
    assert not [f for f in report.contract if f.level == "fault"]
    speed = described(foreign, names).variables["speed"]
    assert speed.unit == "m/s"
    assert (speed.start, speed.minimum, speed.maximum) == pytest.approx((-10.0, -100.0, 20.0))
    height = described(foreign, names).variables[HEIGHT].renaming
    assert height.to_contract(4.0) == pytest.approx(0.006)
    assert height.to_own(0.006) == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("more", "error", "message"),
    [
        (
            {"wheelset[1].vertical_displacment": '"ws1_vertical_displacement"'},
            UnknownNameError,
            r"no variable in the contract .* did you mean wheelset\[1\].vertical_displacement",
        ),
        ({HEIGHT: '"ws1_vertical_displacemen"'}, UnknownNameError, "no variable in Foreign.fmu"),
        ({"wheelset[{i}].radius": '"r{i}"'}, UnknownNameError, "no variable in the contract"),
        ({HEIGHT: '"ws1_yaw_rate"'}, ParameterError, r"already wheelset\[1\].yaw_rate"),
        ({"wheelset[{i}].yaw_rate": '"ws{i}_roll_rate"'}, ParameterError, "already ws1_yaw_rate"),
        ({HEIGHT: "1"}, ParameterError, "must be the name of a variable of the FMU"),
        ({"speed": '{ name = "ws1_yaw_rate", gain = 2 }'}, UnknownNameError, "factor, offset"),
        ({"speed": '{ name = "ws1_yaw_rate", factor = 0 }'}, ParameterError, "must not be 0"),
        ({"speed": '{ name = "ws1_yaw_rate", factor = nan }'}, ParameterError, "finite number"),
        ({"wheelset[{i}].yaw_rate": '"ws1_yaw_rate"'}, ParameterError, "on both sides"),
    ],
)
def test_what_cannot_be_mapped_is_refused_by_name(tmp_path, more, error, message):
    foreign = fmu(tmp_path / "Foreign.fmu", own_names(1))
    names = {"wheelset[1].yaw_rate": "ws1_yaw_rate"}
    with pytest.raises(error, match=message):
        described(foreign, toml(tmp_path, names, **more))


def test_a_variable_that_has_the_name_already_must_make_way(tmp_path):
    foreign = fmu(tmp_path / "Foreign.fmu", own_names(1) | {"speed": ("output", "m/s")})
    description = described(foreign)
    wanted = [Renaming(name="speed", own="ws1_longitudinal_velocity")]
    with pytest.raises(ParameterError, match="another variable of this name"):
        renamed(description, wanted)


def test_factors_are_for_real_numbers_only(tmp_path):
    foreign = fmu(tmp_path / "Foreign.fmu", own_names(1) | {"n": ("parameter", None, "1")})
    names = toml(tmp_path, wheelset_count='{ name = "n", factor = 2 }')
    with pytest.raises(ParameterError, match="is integer; only real variables"):
        described(foreign, names)


def test_dotted_names_need_no_quotes(tmp_path):
    path = tmp_path / "names.toml"
    path.write_text('[names]\nwheelset.radius = "r"\ncontact.wheel_radius = { name = "R" }\n')
    found = {one.name: one.own for one in read_name_map(path)}
    assert found == {"wheelset.radius": "r", "contact.wheel_radius": "R"}


def test_values_are_scaled_only_where_they_differ():
    same = Renaming(name="speed", own="v", factor=1.0, converted=True)
    assert not Variable(name="speed", renaming=same).scaled
    assert Variable(name="speed", renaming=Renaming(name="speed", own="v", factor=-1.0)).scaled


def test_the_trial_run_is_given_the_map(tmp_path):
    """Without a binary it ends in one fault; with a wrong map in that of the map."""
    foreign = fmu(tmp_path / "Foreign.fmu", own_names(1))
    (found,) = trial_findings(foreign, toml(tmp_path, {"speed": "v"}))
    assert "speed = 'v': there is no variable in Foreign.fmu" in found.text

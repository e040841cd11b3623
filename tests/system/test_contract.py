"""What the built FMUs declare: the contract by which other tools connect them."""

import tomllib
from itertools import product as combinations
from pathlib import Path
from zipfile import ZipFile

import fmpy
import pytest
from fmpy.validation import validate_fmu
from lxml import etree
from product import build
from rail_cosim.contract import OUTPUTS

SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi2"
FMUS = ("vehicle", "track")

MOTION = {
    "longitudinal_position": "m",
    "lateral_displacement": "m",
    "vertical_displacement": "m",
    "roll_angle": "rad",
    "yaw_angle": "rad",
    "longitudinal_velocity": "m/s",
    "lateral_velocity": "m/s",
    "vertical_velocity": "m/s",
    "roll_rate": "rad/s",
    "yaw_rate": "rad/s",
    "pitch_rate": "rad/s",
}
FORCES = {
    "longitudinal_force": "N",
    "lateral_force": "N",
    "vertical_force": "N",
    "roll_moment": "N.m",
    "pitch_moment": "N.m",
    "yaw_moment": "N.m",
}
WHEEL = {
    "normal_force": "N",
    "longitudinal_creep_force": "N",
    "lateral_creep_force": "N",
    "penetration": "m",
    "contact_angle": "rad",
    "rail_vertical_displacement": "m",
    "rail_lateral_displacement": "m",
    "rail_roll_angle": "rad",
}
POSE = {
    "lateral_displacement": "m",
    "vertical_displacement": "m",
    "roll_angle": "rad",
    "pitch_angle": "rad",
    "yaw_angle": "rad",
}
SIDES = ("left", "right")
COUNT = None  # a number without a unit

VEHICLE_PARAMETERS = {
    "speed": "m/s",
    "initial_position": "m",
    "initial_lateral_displacement": "m",
    "car_body.mass": "kg",
    "car_body.roll_inertia": "kg.m2",
    "car_body.pitch_inertia": "kg.m2",
    "car_body.yaw_inertia": "kg.m2",
    "bogie.mass": "kg",
    "bogie.roll_inertia": "kg.m2",
    "bogie.pitch_inertia": "kg.m2",
    "bogie.yaw_inertia": "kg.m2",
    "wheelset.mass": "kg",
    "wheelset.roll_inertia": "kg.m2",
    "wheelset.pitch_inertia": "kg.m2",
    "wheelset.yaw_inertia": "kg.m2",
    **{
        f"{stage}_suspension.{way}_{what}": unit
        for stage in ("primary", "secondary")
        for way in ("vertical", "longitudinal", "lateral")
        for what, unit in (("stiffness", "N/m"), ("damping", "N.s/m"))
    },
}
TRACK_PARAMETERS = {
    "rail.youngs_modulus": "Pa",
    "rail.shear_modulus": "Pa",
    "rail.density": "kg/m3",
    "rail.area": "m2",
    "rail.vertical_second_moment": "m4",
    "rail.vertical_shear_coefficient": "1",
    "rail.lateral_second_moment": "m4",
    "rail.lateral_shear_coefficient": "1",
    "rail.polar_second_moment": "m4",
    "rail.torsional_stiffness": "N.m2",
    "rail.gauge": "m",
    "rail.gauge_measurement_depth": "m",
    "rail.cant": "1",
    "rail.mode_count": COUNT,
    "fastener.spacing": "m",
    "fastener.count_per_slab": COUNT,
    "fastener.vertical_stiffness": "N/m",
    "fastener.vertical_damping": "N.s/m",
    "fastener.lateral_stiffness": "N/m",
    "fastener.lateral_damping": "N.s/m",
    "slab.length": "m",
    "slab.width": "m",
    "slab.thickness": "m",
    "slab.density": "kg/m3",
    "slab.youngs_modulus": "Pa",
    "slab.poisson_ratio": "1",
    "slab.damping_ratio": "1",
    "slab.gap": "m",
    "slab.mode_count": COUNT,
    "slab_support.vertical_stiffness": "N/m",
    "slab_support.vertical_damping": "N.s/m",
    "window.slab_count": COUNT,
    "window.sample_count": COUNT,
    "contact.friction_coefficient": "1",
    "contact.rolling_circle_distance": "m",
    "contact.hertz_constant": "m/N^(2/3)",
    "contact.wheel_radius": "m",
    "static_wheel_load": "N",
    "wheelset_count": COUNT,
    "initial_position": "m",
}
TEXTS = {
    "vehicle": {"coupling.input_time": "step_start"},
    "track": {
        "coupling.input_time": "step_start",
        "slab_support.basis": "per_bay",
        "window.method": "sliding",
        "window.slide_solver": "least_squares",
        "contact.wheel_profile": "S1002",
        "contact.rail_profile": "CHN60",
        "irregularity.spectrum": "none",
        "irregularity.file.path": "",
        "interface": "contact",
    },
}


def terminal(members, prefix=""):
    return {
        f"wheelset[{i}].{prefix}{name}": unit for i in range(1, 5) for name, unit in members.items()
    }


def sided(group, numbers, members):
    return {
        f"{group}[{i}].{side}.{name}": unit
        for i, side, (name, unit) in combinations(numbers, SIDES, members.items())
    }


ACCELERATION = {"vertical_acceleration": "m/s2"}
CONTRACT = {
    "vehicle": {
        "input": terminal(FORCES, "contact.") | {"speed_setpoint": "m/s"},
        "output": terminal(MOTION)
        | sided("axle_box", range(1, 5), ACCELERATION)
        | sided("primary_suspension", range(1, 5), {"vertical_deflection": "m"})
        | sided("secondary_suspension", (1, 2), {"vertical_deflection": "m"})
        | {f"bogie[{j}].{name}": u for j in (1, 2) for name, u in (POSE | ACCELERATION).items()}
        | {f"car_body.{name}": unit for name, unit in (POSE | ACCELERATION).items()},
        "parameter": VEHICLE_PARAMETERS | terminal({"initial_vertical_displacement": "m"}),
        "calculatedParameter": {"static_wheel_load": "N"},
    },
    "track": {
        "input": terminal(MOTION)
        | sided(
            "rail_head",
            range(1, 5),
            {"vertical_force": "N", "lateral_force": "N", "roll_moment": "N.m"},
        ),
        "output": terminal(FORCES, "contact.")
        | sided("wheelset", range(1, 5), WHEEL)
        | terminal({"static_vertical_displacement": "m"})
        | {
            "window.start_position": "m",
            "window.slide_count": COUNT,
            "window.slide_residual": "m",
        },
        "parameter": TRACK_PARAMETERS,
        "calculatedParameter": {},
    },
}


@pytest.fixture(scope="module")
def described(fmus):
    return {name: fmpy.read_model_description(str(getattr(fmus, name))) for name in FMUS}


@pytest.mark.parametrize("name", FMUS)
def test_fmpy_finds_no_problem(fmus, name):
    assert validate_fmu(str(getattr(fmus, name))) == []


@pytest.mark.parametrize("name", FMUS)
def test_description_satisfies_the_fmi_schema(fmus, name):
    with ZipFile(getattr(fmus, name)) as archive:
        description = etree.fromstring(archive.read("modelDescription.xml"))
    schema = etree.XMLSchema(etree.parse(SCHEMAS / "fmi2ModelDescription.xsd"))
    schema.assertValid(description)


@pytest.mark.parametrize("name", FMUS)
@pytest.mark.parametrize("causality", ["input", "output", "parameter", "calculatedParameter"])
def test_contract(described, name, causality):
    """Each name of the contract is there, with its causality and unit."""
    found = {v.name: v for v in described[name].modelVariables if v.causality == causality}
    wanted = CONTRACT[name][causality]
    assert sorted(wanted.keys() - found.keys()) == []
    assert {variable: found[variable].unit for variable in wanted} == wanted


@pytest.mark.parametrize("name", FMUS)
def test_outputs_that_evaluation_reads_are_there(described, name):
    found = {v.name: v.unit for v in described[name].modelVariables if v.causality == "output"}
    wanted = {
        pattern.replace("[i]", "[1]").replace("[j]", "[1]"): unit
        for pattern, unit in OUTPUTS[name].items()
    }
    assert {variable: found.get(variable) for variable in wanted} == wanted


@pytest.mark.parametrize("name", FMUS)
def test_version_is_that_of_the_product(described, name):
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
    about = described[name]
    assert (about.version, about.license) == (project["version"], project["license"])


@pytest.mark.parametrize("name", FMUS)
def test_texts_have_their_defaults(described, name):
    found = {v.name: v for v in described[name].modelVariables}
    for variable, default in TEXTS[name].items():
        assert (found[variable].type, found[variable].causality) == ("String", "parameter")
        assert found[variable].start == default


@pytest.mark.parametrize("name", FMUS)
def test_units_are_defined_in_base_units(described, name):
    defined = {unit.name: unit.baseUnit for unit in described[name].unitDefinitions}
    reals = [v for v in described[name].modelVariables if v.type == "Real"]
    assert [v.name for v in reals if v.unit not in defined] == []
    newton = defined["N"]
    assert (newton.kg, newton.m, newton.s) == (1, 1, -2)
    fractional = {"m/N^(2/3)"}  # cannot be said in FMI 2.0: base units have whole exponents
    assert {n for n, base in defined.items() if base is None} <= fractional


@pytest.mark.parametrize("name", FMUS)
def test_each_input_and_parameter_has_a_start_and_a_meaning(described, name):
    variables = described[name].modelVariables
    settable = [v for v in variables if v.causality in ("input", "parameter")]
    assert [v.name for v in settable if v.start is None] == []
    assert [v.name for v in variables if not v.description] == []


def test_terminals_connect_by_equal_names(described):
    """Same name, same unit, opposite causality: all the vehicle's inputs but its speed."""
    sets = {
        (name, causality): {
            (v.name, v.unit) for v in described[name].modelVariables if v.causality == causality
        }
        for name in FMUS
        for causality in ("input", "output")
    }
    unfed = sets["vehicle", "input"] - sets["track", "output"]
    assert unfed == {("speed_setpoint", "m/s")}
    unfed = sets["track", "input"] - sets["vehicle", "output"]
    assert all(name.startswith("rail_head[") for name, _ in unfed)


@pytest.mark.parametrize("name", FMUS)
def test_capabilities(described, name):
    about = described[name].coSimulation
    assert about.canGetAndSetFMUstate
    assert about.canSerializeFMUstate
    assert about.canHandleVariableCommunicationStepSize
    assert not about.canBeInstantiatedOnlyOncePerProcess


def test_presets_are_packed(fmus):
    for path, names in ((fmus.vehicle, ("paper", "manchester1")), (fmus.track, ("HD", "ZX"))):
        with ZipFile(path) as archive:
            packed = archive.namelist()
        assert {f"resources/presets/{name}.ssv" for name in names} <= set(packed)


def test_rebuild_is_identical(tmp_path):
    """Each with an empty cache, so that the FMUs are really built twice."""
    one, other = (build(tmp_path / name / "fmus", tmp_path / name / "cache") for name in "ab")
    for first, second in zip(one.both, other.both, strict=True):
        assert first.read_bytes() == second.read_bytes()

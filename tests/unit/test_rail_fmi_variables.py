"""Table of variables, units and documents."""

import dataclasses
import subprocess
import sys

import pytest
from rail_fmi import (
    TableError,
    Variable,
    VariableTable,
    documentation_table,
    parameter_variables,
)
from rail_fmi.units import base_exponents
from rail_quantities import ParameterError, ParameterSet, quantity


@pytest.mark.parametrize(
    ("unit", "exponents"),
    [
        ("1", {}),
        ("N", {"kg": 1, "m": 1, "s": -2}),
        ("N.m/rad", {"kg": 1, "m": 2, "s": -2, "rad": -1}),
        ("N.s/m", {"kg": 1, "s": -1}),
        ("m/s2", {"m": 1, "s": -2}),
        ("kg.m2", {"kg": 1, "m": 2}),
        ("Pa", {"kg": 1, "m": -1, "s": -2}),
        ("m4", {"m": 4}),
        ("N.m2", {"kg": 1, "m": 3, "s": -2}),
        ("1/m", {"m": -1}),
        ("N/(m.s)", {"kg": 1, "s": -3}),
        ("m/N^(2/3)", None),
    ],
)
def test_units_have_integer_base_exponents(unit, exponents):
    assert base_exponents(unit) == exponents


@pytest.mark.parametrize("unit", ["kN", "mm", "N/m.s", "N//m", "", "m^2", "m/s/s"])
def test_units_that_are_not_si_products_are_refused(unit):
    with pytest.raises(TableError, match="unit"):
        Variable("x", unit=unit)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"kind": "float"}, "kind 'float' is not one of real"),
        ({"causality": "state"}, "causality 'state' is not one of"),
        ({"causality": "parameter", "variability": "continuous"}, "no continuous parameter"),
        ({"causality": "input", "kind": "integer", "variability": "continuous"}, "no continuous"),
        ({"kind": "real", "choices": ("a",)}, "only a string can have choices"),
        ({"start": float("nan")}, "start value: x = nan: must be a finite number"),
        ({"start": 5.0, "maximum": 4.0}, "start value: x = 5.0: must be at most 4"),
        ({"start": 5.0, "maximum": 0.0}, "must be at most 0"),
        ({"kind": "string", "choices": ("a", "b"), "start": "c"}, "must be one of a, b"),
    ],
)
def test_contradictory_variables_are_refused(arguments, message):
    with pytest.raises(TableError, match=message):
        Variable("x", **arguments)


@pytest.mark.parametrize("name", ["", "1a", "a b", "a[1", "a..b", "a[x]", "w[1].", "ä"])
def test_names_that_are_not_structured_are_refused(name):
    with pytest.raises(TableError, match="not a structured FMI name"):
        Variable(name)


@pytest.mark.parametrize(
    ("variable", "value", "message"),
    [
        (Variable("x", minimum=1.0, unit="N"), 0.5, "x = 0.5: must be at least 1 N"),
        (Variable("x", minimum=1, maximum=3, kind="integer"), 2.5, "whole number"),
        (Variable("x", kind="integer"), 2**31, "32 bits"),
        (Variable("x", kind="boolean"), 2, "must be true or false"),
        (Variable("x", kind="string"), 2, "must be text"),
        (Variable("x"), "2", "finite number"),
        (Variable("x"), True, "finite number"),
    ],
)
def test_values_are_checked(variable, value, message):
    with pytest.raises(ParameterError, match=message):
        variable.check(value)


def test_values_come_back_in_the_type_of_the_variable():
    assert Variable("x").check(2) == 2.0
    assert type(Variable("x").check(2)) is float
    assert type(Variable("x", kind="integer").check(2.0)) is int
    assert Variable("x", kind="boolean").check(1) is True


def test_usual_variability_and_start():
    assert Variable("x", causality="parameter").variability == "fixed"
    assert Variable("x", causality="input").variability == "continuous"
    assert Variable("x", causality="output", kind="integer").variability == "discrete"
    assert Variable("x", minimum=2.0).start == 2.0
    assert Variable("x", kind="string", choices=("b", "a")).start == "b"


def test_references_count_from_zero_in_each_kind():
    table = VariableTable(
        [Variable("a"), Variable("n", kind="integer"), Variable("b"), Variable("m", kind="integer")]
    )
    assert [table.reference(name) for name in table] == [0, 0, 1, 1]
    with pytest.raises(TableError, match="a is declared twice"):
        VariableTable([Variable("a"), Variable("a")])


def test_digest_depends_on_all_that_the_table_says():
    base = Variable("a", description="one")
    changes = {"description": "two", "unit": "N", "maximum": 3.0, "start": 1.0}
    digests = {
        VariableTable([dataclasses.replace(base, **{k: v})]).digest for k, v in changes.items()
    }
    assert len(digests | {VariableTable([base]).digest}) == 5


@dataclasses.dataclass(frozen=True, kw_only=True)
class Rail(ParameterSet):
    GROUP = "rail"
    area: float = quantity(7.7e-3, "m2", "Cross section", above=0.0, nominal=1e-2)
    modes: int = quantity(200, "1", "Number of modes", at_least=1, at_most=5000)
    basis: str = quantity("sine", description="Shape functions", choices=("sine", "fourier"))
    damped: bool = quantity(True, description="Whether it is damped")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Track(ParameterSet):
    rail: Rail = Rail()
    load: float = quantity(5.0e4, "N", "Load", below=1.0e6)


def test_parameter_variables_follow_the_parameter_set():
    table = {v.name: v for v in parameter_variables(Track())}
    kinds = {name: variable.kind for name, variable in table.items()}
    assert kinds == {
        "rail.area": "real",
        "rail.modes": "integer",
        "rail.basis": "string",
        "rail.damped": "boolean",
        "load": "real",
    }
    area = table["rail.area"]
    assert (area.unit, area.start, area.minimum, area.nominal) == ("m2", 7.7e-3, 0.0, 1e-2)
    assert (table["rail.modes"].minimum, table["rail.modes"].maximum) == (1, 5000)
    assert table["load"].maximum == 1.0e6
    assert table["rail.basis"].choices == ("sine", "fourier")
    assert all(v.causality == "parameter" and v.variability == "fixed" for v in table.values())


def test_documentation_table():
    lines = documentation_table(parameter_variables(Track())).splitlines()
    assert len(lines) == 2 + 5
    assert (
        lines[2] == "| `rail.area` | parameter | real | m2 | 0.0077 | at least 0 | Cross section |"
    )
    assert "one of sine, fourier" in lines[4]


def test_tables_and_documents_need_no_pythonfmu():
    code = (
        "import sys; sys.modules['pythonfmu'] = None; import rail_fmi;"
        "print(rail_fmi.documentation_table([rail_fmi.Variable('x')]))"
    )
    search = ":".join(path for path in sys.path if path)
    done = subprocess.run(
        [sys.executable, "-c", code], env={"PYTHONPATH": search}, capture_output=True, text=True
    )
    assert "| `x` |" in done.stdout, done.stderr

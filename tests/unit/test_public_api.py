"""The public modules: every name has types, and a docstring with parameters, shapes and units."""

import dataclasses
import importlib
import importlib.util
import inspect
import re
import typing
from pathlib import Path

import pytest

MODULES = (
    "rail_cosim",
    "rail_cosim.errors",
    "rail_cosim.postprocessing",
    "slab_track",
    "slab_track.frequency",
    "rail_vehicle",
)
ROOT = Path(__file__).parents[2]
# A DataArray carries its unit with it, in the attribute units.
_NUMBERS = ("float", "ndarray", "NDArray", "Array")
# What it is their type tells: a data set of a run, parameters, a state.
_TELLING = (
    "Dataset",
    "HistoryOptions",
    "TrackParameters",
    "TrackState",
    "VehicleParameters",
    "VehicleState",
)
_ARRAYS = ("ndarray", "NDArray", "Array")
_UNIT = re.compile(
    r"(?<![\w.'’/])(m|mm|s|N|kg|Hz|rad|Pa|J|km/h|m/s2?|m/N|N/m|N\.m|m/m|m2|m3|1/m|dB|rad/s|N\.s/m|1|°|%|[Ss]econds)"
    r"(?![\w/'’])"
    r"|[Uu]nits?\b|dimensionless|[Ss]hares?\b|[Rr]elative|[Rr]atio|SI\b|[Ff]actor|[Ii]ndex|[Ii]ndices|percent"
)
_SHAPE = re.compile(
    r"[Ss]hapes?\b|\([\w*+. ,:|-]*,[\w*+. ,:|-]*\)|[Dd]imensions?\b|[Ss]calar|as deep"
)


def documented(module):
    """Return the public classes and functions of a module by name, from where it has them."""
    found = importlib.import_module(module)
    names = getattr(found, "__all__", None)
    assert names, f"{module} does not say what is public"
    assert list(names) == sorted(set(names), key=lambda n: (not n.isupper(), n[0].islower(), n))
    return {name: getattr(found, name) for name in names}


def methods(kind):
    for name, member in vars(kind).items():
        if name.startswith("_"):
            continue
        member = member.__func__ if isinstance(member, (classmethod, staticmethod)) else member
        member = getattr(member, "func", member)  # functools.cached_property
        member = member.fget if isinstance(member, property) else member
        if inspect.isfunction(member) and member.__qualname__.startswith(kind.__name__ + "."):
            yield f"{kind.__name__}.{name}", member


def everything():
    for module in MODULES:
        for name, thing in documented(module).items():
            if inspect.isclass(thing):
                yield f"{module}.{name}", thing
                for method, function in methods(thing):
                    yield f"{module}.{method}", function
            elif callable(thing):
                yield f"{module}.{name}", thing


PUBLIC = dict(everything())
FUNCTIONS = {name: thing for name, thing in PUBLIC.items() if inspect.isfunction(thing)}
CLASSES = {name: thing for name, thing in PUBLIC.items() if inspect.isclass(thing)}


def parameters(function):
    found = inspect.signature(function).parameters
    return {name: p for name, p in found.items() if name not in ("self", "cls")}


def entry(doc, name):
    """Return what a docstring says of a parameter: below its name, or the sentence with it."""
    listed = re.search(
        rf"^(?:\w+, )*{name}(?:, \w+)*(?: : .*)?\n((?:[ ]{{4}}.*\n?|\n)+)", doc + "\n", re.MULTILINE
    )
    if listed:
        return listed[1]
    told = re.search(rf"[^.]*``[^`]*\b{name}\b[^`]*``[^.]*(?:\.|$)", doc)
    return told[0] if told else None


def is_a(annotation, kinds):
    return any(re.search(rf"\b{kind}\b", str(annotation)) for kind in kinds)


def test_a_unit_is_told_from_other_letters():
    for text in ("The vehicle's mass.", "the axles’ loads", "Load of fastener N/A", "as in eq. 1a"):
        assert not _UNIT.search(text), text
    for text in ("Mass, kg.", "N and N.m", "Length in m, (w,)", "1/m", "m/s2", "in s; None: all"):
        assert _UNIT.search(text), text


def test_there_is_a_public_api():
    assert len(FUNCTIONS) > 60
    assert len(CLASSES) > 20


@pytest.mark.parametrize("name", FUNCTIONS)
def test_all_parameters_and_results_have_types(name):
    function = FUNCTIONS[name]
    for parameter in parameters(function).values():
        assert parameter.annotation is not parameter.empty, f"{name}: {parameter.name}"
    assert inspect.signature(function).return_annotation is not inspect.Signature.empty, name


@pytest.mark.parametrize("name", FUNCTIONS)
def test_docstrings_tell_of_all_parameters_with_units_and_shapes(name):
    doc = inspect.getdoc(FUNCTIONS[name])
    assert doc, f"{name} has no docstring"
    for parameter in parameters(FUNCTIONS[name]).values():
        told = entry(doc, parameter.name)
        if told is None and is_a(parameter.annotation, _TELLING):
            continue
        assert told is not None, f"{name}: nothing of {parameter.name}"
        if is_a(parameter.annotation, _NUMBERS):
            assert _UNIT.search(told), f"{name}: no unit of {parameter.name}: {told}"
        if is_a(parameter.annotation, _ARRAYS):
            assert _SHAPE.search(doc), f"{name}: no shape"


@pytest.mark.parametrize("name", FUNCTIONS)
def test_docstrings_tell_of_arrays_that_are_returned(name):
    function = FUNCTIONS[name]
    if is_a(inspect.signature(function).return_annotation, _ARRAYS):
        assert _SHAPE.search(inspect.getdoc(function)), f"{name}: no shape of the result"


@pytest.mark.parametrize("name", CLASSES)
def test_fields_of_classes_are_told_with_units(name):
    kind = CLASSES[name]
    doc = inspect.getdoc(kind)
    assert doc, f"{name} has no docstring"
    if dataclasses.is_dataclass(kind):
        fields = {field.name: field for field in dataclasses.fields(kind)}
    elif issubclass(kind, tuple) and hasattr(kind, "_fields"):
        fields = dict.fromkeys(kind._fields)
    else:
        return
    hints = typing.get_type_hints(kind)
    for field, about in fields.items():
        if field.startswith("_") or (about is not None and about.metadata):
            continue  # with metadata: unit and description are checked by the FMU's variables
        if isinstance(hints[field], type) and dataclasses.is_dataclass(hints[field]):
            continue  # a group of parameters with a docstring of its own
        told = entry(doc, field)
        assert told is not None, f"{name}: nothing of {field}"
        if is_a(hints[field], _NUMBERS):
            assert _UNIT.search(told), f"{name}: no unit of {field}: {told}"


@pytest.mark.parametrize(
    "package",
    [
        "master/rail_cosim",
        "fmus/track/slab_track",
        "fmus/vehicle/rail_vehicle",
        "fmus/common/rail_quantities",
        "fmus/common/rail_fmi",
    ],
)
def test_type_checkers_may_use_the_annotations(package):
    assert (ROOT / package / "py.typed").is_file()


def test_the_public_names_are_listed_before_they_are_used():
    """They are loaded on first use; completion must offer them all the same."""
    spec = importlib.util.find_spec("rail_cosim")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert set(module.__all__) <= set(dir(module))
    assert "run" not in vars(module)

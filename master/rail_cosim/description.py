"""What an FMU says of itself: the parts of ``modelDescription.xml`` the master uses."""

from __future__ import annotations

import dataclasses
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from rail_cosim.archives import opened, parse_xml, read_member
from rail_cosim.errors import FmuFileError
from rail_cosim.slave import Kind, Variable

# FMI strings have no list of allowed words; the project's FMUs end the description with it.
_ONE_OF = re.compile(r"\(one of ([^()]+)\)$")
_NUMBERS = ("real", "integer", "enumeration")


@dataclasses.dataclass(frozen=True, kw_only=True)
class FmuDescription:
    """The description of one FMU.

    Attributes
    ----------
    path
        The FMU file.
    model_name, identifier, guid, version, generation_tool
        As declared; empty where not.
    variables
        By name, in declared order.
    units
        For each unit with a base unit: exponents, factor and offset as
        declared, ``{"kg": "1", "m": "1", "s": "-2"}``.
    can_save_state
        Whether the FMU's state can be read and set (rollback).
    can_serialize_state
        Whether it can also be written to a file (checkpoints).
    """

    path: Path
    model_name: str
    identifier: str
    guid: str
    version: str = ""
    generation_tool: str = ""
    variables: Mapping[str, Variable]
    units: Mapping[str, Mapping[str, str]] = dataclasses.field(default_factory=dict)
    can_save_state: bool = False
    can_serialize_state: bool = False


def read_description(path: Path) -> FmuDescription:
    """Read the description of an FMI 2.0 co-simulation FMU without extracting it.

    Raises
    ------
    FmuFileError
        If there is no such file, or it is none that this master can run; says which.
    """
    root = read_root(path)
    version = root.get("fmiVersion", "")
    interface = root.find("CoSimulation")
    if not version.startswith("2.") or interface is None:
        kind = "with" if interface is not None else "without"
        raise FmuFileError(
            f"{path}: this is an FMU of FMI {version or '?'} {kind} co-simulation; "
            "FMI 2.0 for co-simulation is needed"
        )
    types = {e.get("name", ""): e for e in root.iterfind("TypeDefinitions/SimpleType")}
    variables = [
        _sound_variable(path, element, types)
        for element in root.iterfind("ModelVariables/ScalarVariable")
    ]
    return FmuDescription(
        path=path,
        model_name=root.get("modelName", ""),
        identifier=interface.get("modelIdentifier", ""),
        guid=root.get("guid", ""),
        version=root.get("version", ""),
        generation_tool=root.get("generationTool", ""),
        variables={variable.name: variable for variable in variables},
        units={
            unit.get("name", ""): dict(base.attrib)
            for unit in root.iterfind("UnitDefinitions/Unit")
            if (base := unit.find("BaseUnit")) is not None
        },
        can_save_state=interface.get("canGetAndSetFMUstate") in ("true", "1"),
        can_serialize_state=interface.get("canSerializeFMUstate") in ("true", "1"),
    )


def read_root(path: Path) -> ElementTree.Element:
    """Return the root element of an FMU's ``modelDescription.xml``.

    Raises
    ------
    FmuFileError
        If there is none.
    """
    with opened(path) as archive:
        try:
            return parse_xml(read_member(archive, "modelDescription.xml"))
        except (KeyError, ElementTree.ParseError) as error:
            raise FmuFileError(f"{path}: this is no FMU ({error})") from error


def _sound_variable(
    path: Path, element: ElementTree.Element, types: Mapping[str, ElementTree.Element]
) -> Variable:
    try:
        return _variable(element, types)
    except (StopIteration, ValueError) as error:
        reason = "it has no type" if isinstance(error, StopIteration) else error
        raise FmuFileError(
            f"{path}: the description of its variable {element.get('name', '')!r} cannot be read "
            f"({reason})"
        ) from error


def _variable(element: ElementTree.Element, types: Mapping[str, ElementTree.Element]) -> Variable:
    about = next(child for child in element if child.tag != "Annotations")
    kind = about.tag.lower()
    declared = types.get(about.get("declaredType", ""))
    simple = None if declared is None else declared.find(about.tag)
    # A variable's own attributes come before those of its declared type.
    attributes = {} if simple is None else dict(simple.attrib)
    attributes.update(about.attrib)
    items = [] if simple is None else simple.findall("Item")
    choices = {item.get("name", ""): int(item.get("value", "0")) for item in items}
    if kind == "string" and (listed := _ONE_OF.search(element.get("description", ""))):
        choices = {word: i for i, word in enumerate(listed[1].split(", "))}
    return Variable(
        name=element.get("name", ""),
        kind=cast(Kind, kind),
        causality=element.get("causality", "local"),
        variability=element.get("variability", "continuous"),
        unit=attributes.get("unit", ""),
        description=element.get("description", ""),
        start=_start(kind, about.get("start")),
        minimum=_number(kind, attributes.get("min")),
        maximum=_number(kind, attributes.get("max")),
        choices=choices,
        reference=int(element.get("valueReference", "0")),
    )


def _number(kind: str, text: str | None) -> float | None:
    return None if text is None or kind not in _NUMBERS else float(text)


def _start(kind: str, text: str | None) -> Any:
    if text is None or kind == "string":
        return text
    if kind == "boolean":
        return text in ("true", "1")
    return float(text) if kind == "real" else int(text)

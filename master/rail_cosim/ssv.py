"""Parameter sets of SSP 1.0 (``.ssv``): read them, and write them with units."""

from __future__ import annotations

import dataclasses
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Mapping
from xml.etree.ElementTree import Element, SubElement

from rail_cosim.archives import parse_xml
from rail_cosim.errors import FmuFileError
from rail_cosim.slave import Value, Variable

SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
SSC = "{http://ssp-standard.org/SSP1/SystemStructureCommon}"
_TAGS = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String"}
_TAGS["enumeration"] = "Enumeration"


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class Entry:
    """One value of a parameter set: as text, with its unit (empty: that of the variable)."""

    name: str
    value: str
    unit: str = ""


def read_entries(content: bytes, where: str) -> list[Entry]:
    """Return the values of a parameter set.

    Parameters
    ----------
    content
        An ``.ssv`` file.
    where
        What the file is called in messages.

    Raises
    ------
    FmuFileError
        If it cannot be read.
    """
    try:
        root = parse_xml(content)
    except ElementTree.ParseError as error:
        raise FmuFileError(f"{where} cannot be read ({error})") from error
    return entries_of(root)


def entries_of(root: Element) -> list[Entry]:
    """Return the values below an XML element."""
    return [
        Entry(
            name=parameter.get("name", ""),
            value=about.attrib["value"],
            unit=about.get("unit", ""),
        )
        for parameter in root.iter(f"{SSV}Parameter")
        for about in parameter
        if "value" in about.attrib
    ]


def parameter_set(
    name: str,
    values: Mapping[str, Value],
    variables: Mapping[str, Variable],
    units: Mapping[str, Mapping[str, str]],
) -> bytes:
    """Return an ``.ssv`` file.

    Parameters
    ----------
    name
        Name of the set.
    values
        By variable name, in the variables' units.
    variables
        The FMU's variables.
    units
        Base units by name; a unit that is not among them is left out, and a tool
        then takes the variable's own.
    """
    for prefix, space in (("ssv", SSV), ("ssc", SSC)):
        ElementTree.register_namespace(prefix, space.strip("{}"))
    root = Element(f"{SSV}ParameterSet", {"version": "1.0", "name": name})
    parameters = SubElement(root, f"{SSV}Parameters")
    used: set[str] = set()
    for key, value in values.items():
        variable = variables[key]
        about = {"value": as_text(value)}
        if variable.kind == "real" and variable.unit in units:
            about["unit"] = variable.unit
            used.add(variable.unit)
        parent = SubElement(parameters, f"{SSV}Parameter", {"name": key})
        SubElement(parent, f"{SSV}{_TAGS[variable.kind]}", about)
    add_units(root, f"{SSV}Units", sorted(used), units)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def add_units(
    root: Element, tag: str, used: Iterable[str], units: Mapping[str, Mapping[str, str]]
) -> None:
    """Add the definitions of the units that are used, if there are any."""
    names = list(used)
    if not names:
        return
    holder = SubElement(root, tag)
    for name in names:
        unit = SubElement(holder, f"{SSC}Unit", {"name": name})
        SubElement(unit, f"{SSC}BaseUnit", dict(units[name]))


def as_text(value: Value) -> str:
    """Return a value as SSP and OSP write it; a real keeps all its bits."""
    return str(value).lower() if isinstance(value, bool) else str(value)

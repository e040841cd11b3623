"""Parameter sets of SSP 1.0 (``.ssv``): read them, and write them with units."""

from __future__ import annotations

import dataclasses
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Mapping
from xml.etree.ElementTree import Element, SubElement

from rail_cosim.archives import parse_xml
from rail_cosim.errors import FmuFileError, ParameterError
from rail_cosim.slave import Value, Variable

SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
SSC = "{http://ssp-standard.org/SSP1/SystemStructureCommon}"
_TAGS = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String"}
_TAGS["enumeration"] = "Enumeration"
_ABOUT = f"{SSC}Annotations"
_FITTING = {
    "real": ("Real", "Integer"),
    "integer": ("Integer", "Real"),  # `checked` demands a whole number
    "boolean": ("Boolean",),
    "string": ("String", "Enumeration"),  # an FMU may offer the words of a text as a choice
    "enumeration": ("Enumeration", "String", "Integer"),
}


@dataclasses.dataclass(frozen=True, kw_only=True, slots=True)
class Entry:
    """One value of a parameter set.

    Attributes
    ----------
    name, value
        As text.
    type
        What the set says it is: ``Real``, ``Integer``, ``Boolean``, ``String``, ``Enumeration``.
    unit
        Empty for that of the variable.
    """

    name: str
    value: str
    type: str
    unit: str = ""

    def check(self, owner: str, variable: Variable) -> None:
        """Hold type and unit against the variable that the value is for.

        Raises
        ------
        ParameterError
            If they are others; ``owner`` goes before the name in the message.
        """
        name = f"{owner}.{self.name}"
        if self.type not in _FITTING[variable.kind]:
            raise ParameterError(
                name,
                self.value,
                f"is given as {self.type}, but the variable is {_TAGS[variable.kind]}",
                f"write <ssv:{_TAGS[variable.kind]} value=.../>",
            )
        if self.unit and self.unit != (variable.unit or self.unit):
            raise ParameterError(
                name,
                self.value,
                f"is bound in {self.unit}, but the variable is in {variable.unit}",
                "values are not converted: give it in the variable's unit",
            )


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
        If it cannot be read, or what :func:`entries_of` says.
    """
    try:
        root = parse_xml(content)
    except ElementTree.ParseError as error:
        raise FmuFileError(f"{where} cannot be read ({error})") from error
    if root.tag != f"{SSV}ParameterSet":
        raise FmuFileError(
            f"{where}: this is no parameter set of SSP 1.0: its root is {root.tag}, and must be "
            f"{SSV}ParameterSet"
        )
    return entries_of(root, where)


def entries_of(root: Element, where: str) -> list[Entry]:
    """Return the values of a parameter set, or of one that is written in place.

    Raises
    ------
    FmuFileError
        If a parameter has no name, a name is there twice, or it has not one value of one of
        the five types.
    """
    entries: dict[str, Entry] = {}
    for number, parameter in enumerate(root.iter(f"{SSV}Parameter"), start=1):
        name = parameter.get("name", "")
        if not name:
            raise FmuFileError(f"{where}: parameter {number} has no name")
        if name in entries:
            raise FmuFileError(f"{where}: {name} is there twice; a set has each name once")
        entries[name] = _entry(name, parameter, where)
    return list(entries.values())


def _entry(name: str, parameter: Element, where: str) -> Entry:
    given = [about for about in parameter if about.tag != _ABOUT]
    tags = [about.tag.removeprefix(SSV) for about in given]
    known = [SSV + tag for tag in _TAGS.values()]
    if len(given) != 1 or given[0].tag not in known:
        raise FmuFileError(
            f"{where}: {name} must have one value, a {', '.join(_TAGS.values())} of the name "
            f"space {SSV.strip('{}')}; it has {', '.join(tags) or 'none'}"
        )
    (about,), (tag,) = given, tags
    if "value" not in about.attrib:
        raise FmuFileError(f'{where}: the {tag} of {name} has no value; write value="..."')
    return Entry(name=name, value=about.attrib["value"], type=tag, unit=about.get("unit", ""))


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

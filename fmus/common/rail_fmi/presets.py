"""Named parameter sets as SSP 1.0 parameter files (.ssv)."""

from collections.abc import Mapping
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from rail_quantities import UnknownParameterError

from rail_fmi.description import text
from rail_fmi.units import base_exponents
from rail_fmi.variables import VariableTable

_SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
_SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
_TAGS = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String"}


def parameter_file(name: str, values: Mapping[str, Any], table: VariableTable) -> bytes:
    """Return an SSP 1.0 parameter set as XML.

    Units that SSP cannot resolve into base units are left out: the importing
    tool then takes the unit of the FMU's variable, which is the same.

    Raises
    ------
    UnknownParameterError
        For a name that is no parameter of the table.
    rail_quantities.ParameterError
        For a value that the parameter cannot take.
    """
    ElementTree.register_namespace("ssv", _SSV)
    ElementTree.register_namespace("ssc", _SSC)
    known = {variable.name: variable for variable in table.with_causality("parameter")}
    root = Element(f"{{{_SSV}}}ParameterSet", {"version": "1.0", "name": name})
    parameters = SubElement(root, f"{{{_SSV}}}Parameters")
    units: dict[str, dict[str, int]] = {}
    for key, value in values.items():
        if key not in known:
            raise UnknownParameterError(key, value, known)
        variable = known[key]
        attributes = {"value": text(variable.check(value))}
        exponents = base_exponents(variable.unit)
        if variable.kind == "real" and exponents is not None:
            attributes["unit"] = variable.unit
            units[variable.unit] = exponents
        parent = SubElement(parameters, f"{{{_SSV}}}Parameter", {"name": key})
        SubElement(parent, f"{{{_SSV}}}{_TAGS[variable.kind]}", attributes)
    if units:
        definitions = SubElement(root, f"{{{_SSV}}}Units")
        for unit, exponents in units.items():
            element = SubElement(definitions, f"{{{_SSC}}}Unit", {"name": unit})
            base = {key: str(power) for key, power in exponents.items()}
            SubElement(element, f"{{{_SSC}}}BaseUnit", base)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"

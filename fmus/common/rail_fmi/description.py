"""modelDescription.xml from the table of variables (FMI 2.0.4)."""

import dataclasses
from collections.abc import Collection, Mapping
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from rail_fmi.units import base_exponents, quantity_name
from rail_fmi.variables import Variable, VariableTable

_TAGS = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String"}

CAPABILITIES: Mapping[str, str] = {
    "needsExecutionTool": "true",
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "false",
    "maxOutputDerivativeOrder": "0",
    "canRunAsynchronuously": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "false",
}
"""What the slaves can do; ``needsExecutionTool``: a Python interpreter must be there."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class ModelInformation:
    """What the model description says besides the variables.

    Attributes
    ----------
    name
        Model name and identifier.
    guid, date, tool
        Identity, ``generationDateAndTime`` (``2025-01-31T12:00:00Z``), maker.
    attributes
        Optional attributes: description, author, version, copyright, license.
    experiment
        Attributes of ``DefaultExperiment``; empty for none.
    log_categories
        Name and description of each category.
    initial_inputs
        Inputs that an output depends on in initialization mode, by output; all for others.
    """

    name: str
    guid: str
    date: str
    tool: str
    attributes: Mapping[str, str] = dataclasses.field(default_factory=dict)
    experiment: Mapping[str, str] = dataclasses.field(default_factory=dict)
    log_categories: Mapping[str, str] = dataclasses.field(default_factory=dict)
    initial_inputs: Mapping[str, Collection[str]] = dataclasses.field(default_factory=dict)


def model_description(table: VariableTable, about: ModelInformation) -> Element:
    """Return the root element of the model description."""
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0",
            "modelName": about.name,
            "guid": about.guid,
            **about.attributes,
            "generationTool": about.tool,
            "generationDateAndTime": about.date,
            "variableNamingConvention": "structured",
        },
    )
    SubElement(root, "CoSimulation", {"modelIdentifier": about.name, **CAPABILITIES})
    _add_units(root, table)
    _add_types(root, table)
    categories = SubElement(root, "LogCategories")
    for name, description in about.log_categories.items():
        SubElement(categories, "Category", {"name": name, "description": description})
    if about.experiment:
        SubElement(root, "DefaultExperiment", dict(about.experiment))
    variables = SubElement(root, "ModelVariables")
    for variable in table.values():
        _add_variable(variables, variable, table.reference(variable.name))
    _add_structure(root, table, about.initial_inputs)
    return root


def used_units(table: VariableTable) -> list[str]:
    """Return the units of the reals, each once, in order of first use."""
    return list(dict.fromkeys(variable.unit for variable in table.of_kind["real"]))


def _add_units(root: Element, table: VariableTable) -> None:
    units = used_units(table)
    if not units:
        return
    definitions = SubElement(root, "UnitDefinitions")
    for unit in units:
        element = SubElement(definitions, "Unit", {"name": unit})
        exponents = base_exponents(unit)
        if exponents is not None:
            SubElement(element, "BaseUnit", {base: str(n) for base, n in exponents.items()})


def _add_types(root: Element, table: VariableTable) -> None:
    units = used_units(table)
    if not units:
        return
    definitions = SubElement(root, "TypeDefinitions")
    for unit in units:
        name = quantity_name(unit)
        simple = SubElement(definitions, "SimpleType", {"name": name})
        SubElement(simple, "Real", {"quantity": name, "unit": unit})


def text(value: Any) -> str:
    """Return a value as FMI and SSP write it; a real keeps all its bits."""
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, float) else str(value)


def initial_of(variable: Variable) -> str:
    """Return the FMI ``initial``: inputs have none, parameters are exact."""
    if variable.causality == "input":
        return ""
    return "exact" if variable.causality == "parameter" else "calculated"


def _add_variable(parent: Element, variable: Variable, reference: int) -> None:
    attributes = {"name": variable.name, "valueReference": str(reference)}
    description = variable.description
    if variable.choices:
        description = f"{description} ({variable.limits})".strip()
    if description:
        attributes["description"] = description
    attributes["causality"] = variable.causality
    attributes["variability"] = variable.variability
    if initial_of(variable):
        attributes["initial"] = initial_of(variable)
    element = SubElement(parent, "ScalarVariable", attributes)
    details: dict[str, str] = {}
    if variable.kind == "real":
        details = {"declaredType": quantity_name(variable.unit), "unit": variable.unit}
    if variable.kind in ("real", "integer"):
        limits = {"min": variable.minimum, "max": variable.maximum}
        if variable.kind == "real":
            limits["nominal"] = variable.nominal
        number = float if variable.kind == "real" else int
        details |= {key: text(number(v)) for key, v in limits.items() if v is not None}
    if variable.settable:
        details["start"] = text(variable.start)
    SubElement(element, _TAGS[variable.kind], details)


def _add_structure(
    root: Element, table: VariableTable, initial_inputs: Mapping[str, Collection[str]]
) -> None:
    """Add the outputs, and as initial unknowns all calculated outputs and parameters.

    Between steps outputs stay as they are whatever is set, so they depend on nothing. In
    initialization mode what they depend on is told in full, with all parameters.
    """
    structure = SubElement(root, "ModelStructure")
    index = {name: i for i, name in enumerate(table, 1)}
    parameters = [index[v.name] for v in table.with_causality("parameter")]
    if outputs := table.with_causality("output"):
        parent = SubElement(structure, "Outputs")
        for variable in outputs:
            about = {"index": str(index[variable.name]), "dependencies": ""}
            SubElement(parent, "Unknown", about)
    unknowns = [v for v in table.values() if v.causality in ("output", "calculatedParameter")]
    if unknowns:
        parent = SubElement(structure, "InitialUnknowns")
        for variable in unknowns:
            about = {"index": str(index[variable.name])}
            if variable.name in initial_inputs:
                inputs = [index[name] for name in initial_inputs[variable.name]]
                about["dependencies"] = " ".join(map(str, sorted([*inputs, *parameters])))
            SubElement(parent, "Unknown", about)

"""Write the pair as a system of the Open Simulation Platform: ``OspSystemStructure.xml``.

Elements and attributes as in OspSystemStructure.xsd 0.1.1 of libcosim.
"""

from __future__ import annotations

import io
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from rail_cosim.connections import connect
from rail_cosim.description import read_description
from rail_cosim.options import MACRO_STEP
from rail_cosim.parameters import checked
from rail_cosim.presets import read_preset
from rail_cosim.slave import Value, Variable
from rail_cosim.ssv import as_text

OSP_NAME = "OspSystemStructure.xml"
_SPACE = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"
_TAGS = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "string": "String"}


def write_osp(
    path: Path,
    fmus: Mapping[str, Path],
    presets: Mapping[str, str],
    start: Mapping[str, Mapping[str, Value]] | None = None,
    step_size: float = MACRO_STEP,
) -> None:
    """Write a system of FMUs that lie in the same folder, connected by equal names.

    Parameters
    ----------
    path
        The file; libcosim wants it to be called ``OspSystemStructure.xml``.
    fmus
        FMU file by simulator name.
    presets
        For a simulator the parameter set whose values it gets.
    start
        Further values by simulator and variable; they win.
    step_size
        Of the fixed-step algorithm, s.

    Raises
    ------
    StructureError
        If the FMUs do not fit together.
    """
    descriptions = {name: read_description(fmu) for name, fmu in fmus.items()}
    known = {name: description.variables for name, description in descriptions.items()}
    connections, _ = connect(known)
    root = Element("OspSystemStructure", {"xmlns": _SPACE, "version": "0.1"})
    for name, text in (
        ("StartTime", "0.0"),
        ("BaseStepSize", repr(step_size)),
        ("Algorithm", "fixedStep"),
    ):
        SubElement(root, name).text = text
    simulators = SubElement(root, "Simulators")
    for name, fmu in fmus.items():
        about = {"name": name, "source": fmu.name, "stepSize": repr(step_size)}
        simulator = SubElement(simulators, "Simulator", about)
        values: dict[str, Value] = {}
        if name in presets:
            found = read_preset(fmu, presets[name], name)
            values |= checked(name, known[name], found)
        _initial_values(simulator, values | dict((start or {}).get(name, {})), known[name])
    holder = SubElement(root, "Connections")
    for connection in connections:
        pair = SubElement(holder, "VariableConnection")
        for simulator in (connection.source, connection.target):
            SubElement(pair, "Variable", {"simulator": simulator, "name": connection.name})
    ElementTree.indent(root)
    buffer = io.BytesIO()
    ElementTree.ElementTree(root).write(buffer, encoding="utf-8", xml_declaration=True)
    path.write_bytes(buffer.getvalue() + b"\n")


def _initial_values(
    simulator: Element, values: Mapping[str, Value], variables: Mapping[str, Variable]
) -> None:
    if not values:
        return
    holder = SubElement(simulator, "InitialValues")
    for name, value in values.items():
        kind = variables[name].kind
        if kind not in _TAGS:  # OSP has no enumerations
            continue
        initial = SubElement(holder, "InitialValue", {"variable": name})
        SubElement(initial, _TAGS[kind], {"value": as_text(value)})

"""Write the pair as an SSP 1.0 package: what is connected with what, for other tools."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ElementTree
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from rail_cosim.connections import Connection, connect
from rail_cosim.description import FmuDescription, read_description
from rail_cosim.options import MACRO_STEP
from rail_cosim.presets import preset_files
from rail_cosim.slave import Value, Variable
from rail_cosim.ssv import SSC as _SSC
from rail_cosim.ssv import add_units, parameter_set

_ROOT = "http://ssp-standard.org/SSP1/"
_SSD = f"{{{_ROOT}SystemStructureDescription}}"
_OSP = "{http://opensimulationplatform.com/SSP/OSPAnnotations}"
STOP_TIME = 1.0
"""What a tool simulates unless it is told, s."""
START = "start"
SYSTEM_START = "system-start"
_KEEP_FIRST_INPUTS = "coupling.keep_first_inputs"
_SSV_TYPE = "application/x-ssp-parameter-set"
_FIXED_TIME = (2000, 1, 1, 0, 0, 0)  # the same content gives the same file


def write_ssp(
    path: Path,
    fmus: Mapping[str, Path],
    presets: Mapping[str, str],
    start: Mapping[str, Mapping[str, Value]] | None = None,
) -> None:
    """Write an SSP with these FMUs, connected by equal names.

    Parameters
    ----------
    path
        The ``.ssp`` to write.
    fmus
        FMU file by component name.
    presets
        For a component the parameter set it is bound to, of those its FMU
        carries; the others are in the package too, to be exchanged for it.
    start
        Further values by component and variable, bound after that as a set
        called ``start``. The set ``system-start`` has them of all components, for tools
        that take one set by hand and pass nothing on before the first step; no one is bound to it.

    Raises
    ------
    StructureError
        If the FMUs do not fit together.
    """
    descriptions = {name: read_description(fmu) for name, fmu in fmus.items()}
    files: dict[str, bytes] = {}
    bindings: dict[str, list[str]] = {}
    for name, fmu in fmus.items():
        files[f"resources/{fmu.name}"] = fmu.read_bytes()
        for preset, content in preset_files(fmu).items():
            member = f"resources/{name}-{preset}.ssv"
            files[member] = content
            if presets.get(name) == preset:
                bindings.setdefault(name, []).append(member)
    for name, values in (start or {}).items():
        about, member = descriptions[name], f"resources/{name}-{START}.ssv"
        files[member] = parameter_set(START, values, about.variables, about.units)
        bindings.setdefault(name, []).append(member)
    if start:
        files[f"resources/{SYSTEM_START}.ssv"] = _system_start(start, descriptions)
    files["SystemStructure.ssd"] = structure(path.stem, descriptions, bindings)
    _write_zip(path, files)


def _system_start(
    start: Mapping[str, Mapping[str, Value]], descriptions: Mapping[str, FmuDescription]
) -> bytes:
    values: dict[str, Value] = {}
    variables: dict[str, Variable] = {}
    for name, given in start.items():
        about = descriptions[name].variables
        keep = {_KEEP_FIRST_INPUTS: True} if _KEEP_FIRST_INPUTS in about else {}
        for key, value in {**given, **keep}.items():
            values[f"{name}.{key}"], variables[f"{name}.{key}"] = value, about[key]
    units = {unit: base for d in descriptions.values() for unit, base in d.units.items()}
    return parameter_set(SYSTEM_START, values, variables, units)


def structure(
    title: str,
    descriptions: Mapping[str, FmuDescription],
    bindings: Mapping[str, Sequence[str]],
) -> bytes:
    """Return the ``SystemStructure.ssd`` of a system.

    Components have a connector for every real output and for every input that
    is connected. Inputs that nothing feeds are left out, as the standard
    allows: some tools (fmpy) give 0 to any input that is listed.

    Parameters
    ----------
    title
        Name of the system.
    descriptions
        The FMUs by component name.
    bindings
        For a component the ``.ssv`` files bound to it, as paths in the package;
        later ones win.
    """
    for prefix, space in (("ssd", _SSD), ("ssc", _SSC), ("osp", _OSP)):
        ElementTree.register_namespace(prefix, space.strip("{}"))
    connections, _ = connect({name: d.variables for name, d in descriptions.items()})
    root = Element(f"{_SSD}SystemStructureDescription", {"version": "1.0", "name": title})
    system = SubElement(root, f"{_SSD}System", {"name": title})
    elements = SubElement(system, f"{_SSD}Elements")
    used: set[str] = set()
    for name, description in descriptions.items():
        used |= _component(elements, name, description, connections, bindings.get(name, ()))
    _connections(system, connections)
    _units(root, used, descriptions.values())
    _experiment(root)
    ElementTree.indent(root)
    buffer = io.BytesIO()
    ElementTree.ElementTree(root).write(buffer, encoding="utf-8", xml_declaration=True)
    return buffer.getvalue()


def _experiment(root: Element) -> None:
    """Add span and step of time; SSP 1.0 has no field for the step, so it is OSP's annotation."""
    span = {"startTime": "0.0", "stopTime": repr(STOP_TIME)}
    experiment = SubElement(root, f"{_SSD}DefaultExperiment", span)
    annotations = SubElement(experiment, f"{_SSD}Annotations")
    about = {"type": "com.opensimulationplatform"}
    annotation = SubElement(annotations, f"{_SSC}Annotation", about)
    algorithm = SubElement(annotation, f"{_OSP}Algorithm")
    SubElement(algorithm, f"{_OSP}FixedStepAlgorithm", {"baseStepSize": repr(MACRO_STEP)})


def _component(
    elements: Element,
    name: str,
    description: FmuDescription,
    connections: Iterable[Connection],
    bindings: Sequence[str],
) -> set[str]:
    """Add a component; return the units its connectors use."""
    component = SubElement(
        elements,
        f"{_SSD}Component",
        {
            "name": name,
            "type": "application/x-fmu-sharedlibrary",
            "source": f"resources/{description.path.name}",
            "implementation": "CoSimulation",
        },
    )
    fed = {c.name for c in connections if c.target == name}
    connectors = SubElement(component, f"{_SSD}Connectors")
    units: set[str] = set()
    for variable in description.variables.values():
        shown = variable.causality == "output" or variable.name in fed
        if variable.kind != "real" or not shown:
            continue
        about = {"name": variable.name, "kind": variable.causality}
        connector = SubElement(connectors, f"{_SSD}Connector", about)
        known = variable.unit in description.units
        SubElement(connector, f"{_SSC}Real", {"unit": variable.unit} if known else {})
        if known:
            units.add(variable.unit)
    if bindings:
        holder = SubElement(component, f"{_SSD}ParameterBindings")
    for binding in bindings:
        SubElement(holder, f"{_SSD}ParameterBinding", {"type": _SSV_TYPE, "source": binding})
    return units


def _connections(system: Element, connections: Iterable[Connection]) -> None:
    holder = SubElement(system, f"{_SSD}Connections")
    for connection in connections:
        SubElement(
            holder,
            f"{_SSD}Connection",
            {
                "startElement": connection.source,
                "startConnector": connection.name,
                "endElement": connection.target,
                "endConnector": connection.name,
            },
        )


def _units(root: Element, used: set[str], descriptions: Iterable[FmuDescription]) -> None:
    definitions = {name: base for d in descriptions for name, base in d.units.items()}
    add_units(root, f"{_SSD}Units", sorted(used), definitions)


def _write_zip(path: Path, files: Mapping[str, bytes]) -> None:
    scratch = path.with_name(f".{path.name}.part")
    try:
        with zipfile.ZipFile(scratch, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in sorted(files):
                about = zipfile.ZipInfo(name, _FIXED_TIME)
                about.compress_type = zipfile.ZIP_DEFLATED
                about.external_attr = 0o644 << 16
                archive.writestr(about, files[name])
        scratch.replace(path)
    finally:
        scratch.unlink(missing_ok=True)

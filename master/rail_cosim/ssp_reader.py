"""Read a system of a vehicle and a track from an SSP 1.0 package."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import tempfile
import xml.etree.ElementTree as ElementTree
import zipfile
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path, PurePosixPath
from xml.etree.ElementTree import Element

from rail_cosim.archives import LARGEST, opened, parse_xml, read_member
from rail_cosim.cache import cache_directory
from rail_cosim.connections import Connection, connect
from rail_cosim.contract import role_of
from rail_cosim.description import FmuDescription, read_description
from rail_cosim.errors import FmuFileError, StructureError, UnknownNameError
from rail_cosim.ssv import Entry, entries_of, read_entries

_SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
_STRUCTURE = "SystemStructure.ssd"


@dataclasses.dataclass(frozen=True, kw_only=True)
class SspSystem:
    """A pair as a package describes it.

    Attributes
    ----------
    names
        The package's component name by role (``vehicle``, ``track``).
    descriptions
        The FMUs by role.
    parameters
        Values bound to them as text, by role and variable; a later binding wins.
    remarks
        What the user should know.
    """

    names: Mapping[str, str]
    descriptions: Mapping[str, FmuDescription]
    parameters: Mapping[str, Mapping[str, str]]
    remarks: Sequence[str] = ()


def read_ssp(path: Path) -> SspSystem:
    """Read an SSP package with one vehicle and one track.

    The two are told apart by their variables, whatever they are called. The
    connections must be those between equal names, which a run makes.

    Raises
    ------
    FmuFileError
        If it is no SSP package, or a file in it is missing or broken.
    StructureError
        If it holds anything else than such a pair.
    ParameterError
        If a value is bound in another unit or type than its variable has, or to no component.
    """
    with opened(path, "SSP package") as archive:
        try:
            root = parse_xml(read_member(archive, _STRUCTURE))
        except (KeyError, ElementTree.ParseError) as error:
            raise FmuFileError(f"{path}: this is no SSP package ({error})") from error
        package = _Package(path, archive, root)
        components = package.components()
        descriptions = {
            name: read_description(package.fmu(element)) for name, element in components.items()
        }
        names = _roles(path, descriptions)
        bound = package.bound(components, descriptions)
        lines = package.connections()
    by_role = {role: descriptions[name] for role, name in names.items()}
    remarks = _check_connections(path, lines, descriptions)
    return SspSystem(
        names=names,
        descriptions=by_role,
        parameters={role: bound[name] for role, name in names.items()},
        remarks=remarks,
    )


def _roles(path: Path, descriptions: Mapping[str, FmuDescription]) -> dict[str, str]:
    found: dict[str, list[str]] = {"vehicle": [], "track": []}
    for name, description in descriptions.items():
        role = role_of(description.variables)
        if role is None:
            raise StructureError(
                f"{path}: the component {name} is neither a vehicle nor a track; "
                f"`rail-cosim check` on {description.path} says why"
            )
        found[role].append(name)
    for role, names in found.items():
        if len(names) != 1:
            raise StructureError(
                f"{path}: there must be one {role}; there are {len(names)} "
                f"({', '.join(names) or 'none'})"
            )
    return {role: names[0] for role, names in found.items()}


class _Package:
    """The open package and its system."""

    def __init__(self, path: Path, archive: zipfile.ZipFile, root: Element) -> None:
        self.path, self.archive = path, archive
        system = root.find(f"{_SSD}System")
        if system is None:
            raise FmuFileError(f"{path}: {_STRUCTURE} has no System")
        self.system = system

    def components(self) -> dict[str, Element]:
        elements = list(self.system.iterfind(f"{_SSD}Elements/*"))
        for element in elements:
            if element.tag != f"{_SSD}Component":
                kind = element.tag.removeprefix(_SSD)
                raise StructureError(
                    f"{self.path}: {element.get('name')} is a {kind}; only components that are "
                    "FMUs can be run: one vehicle and one track"
                )
        return {element.get("name", ""): element for element in elements}

    def fmu(self, component: Element) -> Path:
        """Put a component's FMU into the cache, keyed by its content."""
        source = component.get("source", "")
        content = self.read(source)
        folder = cache_directory() / "systems" / hashlib.sha256(content).hexdigest()[:16]
        target = folder / PurePosixPath(source).name
        if not target.is_file():
            folder.mkdir(parents=True, exist_ok=True)
            handle, scratch = tempfile.mkstemp(prefix=".part-", dir=folder)
            with os.fdopen(handle, "wb") as file:
                file.write(content)
            os.replace(scratch, target)
        return target

    def read(self, source: str) -> bytes:
        try:
            return read_member(self.archive, source, LARGEST)
        except KeyError as error:
            raise FmuFileError(f"{self.path}: there is no {source!r} in the package") from error

    def bound(
        self, components: Mapping[str, Element], descriptions: Mapping[str, FmuDescription]
    ) -> dict[str, dict[str, str]]:
        """Return the values bound to each component; those of the system win."""
        found: dict[str, dict[str, str]] = {}
        above = self._of_the_system(components)
        for name, component in components.items():
            entries = self._entries(component, descriptions[name].path)
            entries += above.get(name, [])
            found[name] = {entry.name: entry.value for entry in entries}
            for entry in entries:
                if entry.name in descriptions[name].variables:  # others are refused with the rest
                    entry.check(name, descriptions[name].variables[entry.name])
        return found

    def _of_the_system(self, components: Collection[str]) -> dict[str, list[Entry]]:
        """Return the values bound above the components, by component."""
        found: dict[str, list[Entry]] = {}
        for entry in self._entries(self.system, None):
            owner, _, variable = entry.name.partition(".")
            if owner not in components:
                known = [f"{component}.{variable or owner}" for component in components]
                raise UnknownNameError(entry.name, entry.value, known, "component's parameter")
            found.setdefault(owner, []).append(dataclasses.replace(entry, name=variable))
        return found

    def _entries(self, element: Element, fmu: Path | None) -> list[Entry]:
        entries: list[Entry] = []
        for binding in element.iterfind(f"{_SSD}ParameterBindings/{_SSD}ParameterBinding"):
            if binding.find(f"{_SSD}ParameterMapping") is not None:
                raise StructureError(
                    f"{self.path}: the binding of {binding.get('source', 'values')} has a "
                    "ParameterMapping, which is not supported; name the variables in the .ssv"
                )
            prefix = binding.get("prefix", "")
            entries += [
                dataclasses.replace(entry, name=prefix + entry.name)
                for entry in self._binding(binding, fmu)
            ]
        return entries

    def _binding(self, binding: Element, fmu: Path | None) -> list[Entry]:
        source = binding.get("source")
        if source is None:
            return entries_of(binding, f"{self.path}: {_STRUCTURE}")  # written in place
        where = f"{self.path}: {source}"
        if binding.get("sourceBase") == "component" and fmu is not None:
            with opened(fmu) as archive:
                if source not in archive.namelist():
                    raise FmuFileError(f"{where} is not in {fmu.name}")
                return read_entries(read_member(archive, source), where)
        return read_entries(self.read(source), where)

    def connections(self) -> list[tuple[str, str, str, str]]:
        """Return start element and connector, end element and connector of each connection."""
        keys = ("startElement", "startConnector", "endElement", "endConnector")
        lines = self.system.iterfind(f"{_SSD}Connections/{_SSD}Connection")
        return [tuple(line.get(key, "") for key in keys) for line in lines]  # type: ignore[misc]


def _check_connections(
    path: Path,
    lines: Iterable[tuple[str, str, str, str]],
    descriptions: Mapping[str, FmuDescription],
) -> list[str]:
    """Hold the package's connections against those of equal names."""
    made, _ = connect({name: d.variables for name, d in descriptions.items()})
    wanted = {(c.source, c.name, c.target): c for c in made}
    given: set[tuple[str, str, str]] = set()
    for start, output, end, inlet in lines:
        text = f"{path}: the connection of {start}.{output} with {end}.{inlet}"
        if output != inlet:
            raise StructureError(f"{text} joins different names; only equal names are connected")
        if (start, output, end) not in wanted:
            raise StructureError(
                f"{text} is none: there is no output of this name on one side and no input on "
                "the other, both real"
            )
        given.add((start, output, end))
    return _left_open([c for key, c in wanted.items() if key not in given])


def _left_open(connections: Sequence[Connection]) -> list[str]:
    if not connections:
        return []
    first = connections[0]
    more = f" and {len(connections) - 1} more" if len(connections) > 1 else ""
    return [
        f"the package leaves {first.target}.{first.name}{more} open, though {first.source} has the "
        "output; a run connects all equal names"
    ]

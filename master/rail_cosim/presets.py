"""Named parameter sets that an FMU carries: SSP parameter files in ``resources/presets``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from rail_cosim.archives import opened, read_member
from rail_cosim.description import FmuDescription
from rail_cosim.errors import UnknownNameError
from rail_cosim.parameters import checked
from rail_cosim.slave import Value
from rail_cosim.ssv import read_entries

FOLDER = "resources/presets/"


def preset_files(fmu: Path) -> dict[str, bytes]:
    """Return ``{name: content of the .ssv file}`` of the presets inside an FMU."""
    with opened(fmu) as archive:
        names = sorted(n for n in archive.namelist() if n.startswith(FOLDER) and n.endswith(".ssv"))
        return {PurePosixPath(name).stem: read_member(archive, name) for name in names}


def read_preset(fmu: Path, name: str, option: str) -> dict[str, str]:
    """Return the values of one preset as text by parameter name.

    Raises
    ------
    UnknownNameError
        If the FMU has no preset of this name; ``option`` is named in the message.
    FmuFileError
        If the file in the FMU cannot be read.
    """
    files = preset_files(fmu)
    if name not in files:
        raise UnknownNameError(option, name, files, f"parameter set in {fmu.name}", wanted=name)
    entries = read_entries(files[name], f"{fmu}: {FOLDER}{name}.ssv")
    return {entry.name: entry.value for entry in entries}


def preset_values(
    descriptions: Mapping[str, FmuDescription], presets: Mapping[str, str]
) -> dict[str, dict[str, Value]]:
    """Return the checked values of the presets named for some slaves, by slave and parameter.

    Raises
    ------
    UnknownNameError
        If an FMU has no preset of this name.
    ParameterError
        If a value of it is not right.
    """
    option_of = {"track": "--line", "vehicle": "--vehicle"}
    values = {}
    for name, preset in presets.items():
        found = read_preset(descriptions[name].path, preset, option_of[name])
        values[name] = checked(name, descriptions[name].variables, found)
    return values

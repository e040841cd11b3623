"""The frequency view of the track, computed by its own package in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from rail_cosim.builder import child_environment
from rail_cosim.errors import ParameterError, RailCosimError, UnknownNameError
from rail_cosim.studies.base import StudyOptions

MODULE = "slab_track.frequency"

# A frame rests on two wheelsets.
VEHICLE = {
    "vehicle.wheelset.mass": ("mass", 1.0),
    "vehicle.wheelset.roll_inertia": ("roll_inertia", 1.0),
    "vehicle.primary_suspension.vertical_stiffness": ("primary_stiffness", 1.0),
    "vehicle.primary_suspension.vertical_damping": ("primary_damping", 1.0),
    "vehicle.primary_suspension.half_span": ("primary_half_span", 1.0),
    "vehicle.bogie.mass": ("frame_mass", 0.5),
    "vehicle.bogie.roll_inertia": ("frame_roll_inertia", 0.5),
}
"""Parameters of the vehicle that the track feels here: name in the computation, and factor."""


class TrackTable(NamedTuple):
    """What was computed.

    Attributes
    ----------
    about
        Single figures by name, SI units.
    parameters
        Parameters of the track by dotted name.
    columns
        Arrays by name, real or complex.
    """

    about: dict[str, float]
    parameters: dict[str, Any]
    columns: dict[str, np.ndarray]

    def described(self, study: str, command: str) -> xr.Dataset:
        """Return an empty Dataset with figures and parameters as attributes."""
        attributes: dict[str, Any] = {"study": study, "command": command, **self.about}
        for name, value in self.parameters.items():
            attributes[f"track.{name}"] = int(value) if isinstance(value, bool) else value
        return xr.Dataset(attrs=attributes)


class TrackRefusedError(RailCosimError):
    """The track refused a parameter."""

    exit_status = 2


def setting_arguments(settings: Sequence[str], *, wheelset: bool) -> list[str]:
    """Return the computation's arguments for ``track.NAME=VALUE`` and ``vehicle.NAME=VALUE``.

    Raises
    ------
    ParameterError
        For a text without value, or a number that is none.
    UnknownNameError
        For a parameter of the vehicle that does not matter here.
    """
    arguments = []
    known = VEHICLE if wheelset else {}
    for text in settings:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals:
            raise ParameterError("--set", text, "there is no value", f"write {name}=VALUE")
        if name.startswith("track."):
            arguments.append(f"--track={name.removeprefix('track.')}={value}")
        elif name in known:
            inner, factor = known[name]
            arguments.append(f"--wheelset={inner}={factor * _number(name, value)!r}")
        else:
            names = ["track.NAME", *known]
            raise UnknownNameError(name, value, names, "parameter for this study", listed=True)
    return arguments


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ParameterError(name, text, "must be a number") from None


def compute(
    table: str,
    options: StudyOptions,
    *,
    wheelset: bool = False,
    module: str = MODULE,
    line: str = "HD",
) -> TrackTable:
    """Return a table computed by ``python -m slab_track.frequency`` or another ``module``.

    ``line`` names the parameter set of the track.

    Raises
    ------
    RailCosimError
        With what it says, if it fails.
    """
    arguments = [f"--line={line}", *setting_arguments(options.settings, wheelset=wheelset)]
    if options.quick:
        arguments.append("--quick")
    with tempfile.TemporaryDirectory(prefix="rail-cosim-") as folder:
        out = Path(folder, "table.json")
        command = [sys.executable, "-m", module, table, *arguments, "--out", str(out)]
        done = subprocess.run(
            command, capture_output=True, text=True, check=False, env=child_environment()
        )
        if done.returncode != 0:
            said = done.stderr.strip().splitlines()
            reason = said[-1] if said else f"exit status {done.returncode}"
            kind = TrackRefusedError if done.returncode == 2 else RailCosimError
            raise kind(reason.removeprefix(f"{module}: error: "))
        content = json.loads(out.read_text(encoding="utf-8"))
    columns = {name: _array(values) for name, values in content["columns"].items()}
    return TrackTable(content["about"], content["parameters"], columns)


def _array(values: Any) -> np.ndarray:
    if isinstance(values, dict):
        return np.array(values["real"]) + 1j * np.array(values["imag"])
    return np.array(values)


def add_complex(
    dataset: xr.Dataset, name: str, dims: Sequence[str], values: np.ndarray, unit: str, meaning: str
) -> None:
    """Add magnitude and phase of complex ``values``: NetCDF has no complex numbers."""
    dataset[f"{name}_magnitude"] = (dims, np.abs(values), {"units": unit, "long_name": meaning})
    about_phase = {"units": "rad", "long_name": f"phase of: {meaning}"}
    dataset[f"{name}_phase"] = (dims, np.angle(values), about_phase)

"""What reads files and bytes from elsewhere, as functions of arbitrary bytes.

A target returns if the bytes were taken or refused as they should be; anything else that it
raises is a finding.
"""

import contextlib
import hashlib
import io
import math
import os
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rail_cosim.case import read_case
from rail_cosim.description import read_description
from rail_cosim.errors import RailCosimError
from rail_cosim.ssp_reader import read_ssp
from rail_cosim.ssv import read_entries
from rail_cosim.sweeps.specification import read_specification
from rail_fmi.errors import StateError
from rail_fmi.state import FmuState, from_bytes, to_bytes
from rail_quantities import ParameterError
from slab_track.contact.profile_file import load_profile
from slab_track.irregularity.files import read_file
from slab_track.irregularity.table import knots_of_columns

_FOLDER = tempfile.TemporaryDirectory(prefix="fuzz_")
_DIGEST = hashlib.sha256().digest_size


class Target(NamedTuple):
    """One reader: ``check`` takes bytes; ``seeds`` are good ones to begin with."""

    check: Callable[[bytes], None]
    seeds: Callable[[], list[bytes]]


def _file(data: bytes, name: str) -> Path:
    path = Path(_FOLDER.name, name)
    path.write_bytes(data)
    return path


def profile(data: bytes) -> None:
    """Measured profile of a wheel, or of a rail if the first byte is odd."""
    kind = "rail" if data[:1] and data[0] % 2 else "wheel"
    with contextlib.suppress(ParameterError):
        found = load_profile(kind, str(_file(data[1:], "profile.txt")), 1e-5 * (len(data) % 2))
        y = np.linspace(found.start, found.end, 50)
        assert np.isfinite([found.derivative(y, order) for order in range(3)]).all()


def irregularity(data: bytes) -> None:
    """Measured irregularity: CSV, or NetCDF by its first bytes."""
    with contextlib.suppress(ParameterError):
        columns = read_file(str(_file(data, "line.csv")))
        knots, values = knots_of_columns(columns, 3.0, 20.0)
        assert np.isfinite(knots).all()
        assert np.isfinite(values).all()
        assert (np.diff(knots) > 0.0).all()


def case(data: bytes) -> None:
    """Run file."""
    with contextlib.suppress(RailCosimError):
        read_case(_file(data, "case.toml"))


def sweep(data: bytes) -> None:
    """Specification of a sweep."""
    with contextlib.suppress(RailCosimError):
        read_specification(_file(data, "sweep.toml"))


def ssv(data: bytes) -> None:
    """Parameter set."""
    with contextlib.suppress(RailCosimError):
        for entry in read_entries(data, "set.ssv"):
            assert isinstance(entry.name, str)
            assert isinstance(entry.value, str)


def _archive(data: bytes, member: str) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        archive.writestr(member, data)
    return made.getvalue()


def ssp(data: bytes) -> None:
    """System package: the structure in it, or the archive itself."""
    whole = data if data[:2] == b"PK" else _archive(data, "SystemStructure.ssd")
    with contextlib.suppress(RailCosimError):
        read_ssp(_file(whole, "system.ssp"))


def description(data: bytes) -> None:
    """Model description of an FMU, or the archive itself."""
    whole = data if data[:2] == b"PK" else _archive(data, "modelDescription.xml")
    with contextlib.suppress(RailCosimError):
        read_description(_file(whole, "model.fmu"))


def state(data: bytes) -> None:
    """State of an FMU, as it is or with a digest that fits; what is taken comes back whole."""
    for trial in (data, data + hashlib.sha256(data).digest(), _signed(data)):
        with contextlib.suppress(StateError):
            found = from_bytes(trial)
            again = from_bytes(to_bytes(found))
            assert again.mode == found.mode
            assert list(again.values) == list(found.values)
            assert again.time == found.time or math.isnan(found.time)


def _signed(data: bytes) -> bytes:
    body = data[: max(0, len(data) - _DIGEST)]
    return body + hashlib.sha256(body).digest()


def _profile_seeds() -> list[bytes]:
    seeds = []
    for first, low, high in ((b"\0", -0.050, 0.035), (b"\1", -0.036, 0.036)):
        y = np.linspace(low, high, 60)
        z = 6.0 * y**2 + np.where(y < -0.03, 60.0 * (y + 0.03) ** 2, 0.0)
        rows = "\n".join(f"{1e3 * a:.3f}; {1e3 * b:.4f}" for a, b in zip(y, z, strict=True))
        seeds.append(first + f"# unit: mm\n{rows}\n".encode())
    return seeds


def _irregularity_seeds() -> list[bytes]:
    rails = "distance [km], left_vertical [mm], right_vertical\n0, 0.1, 1e-4\n0.001, 0.2, 0\n"
    track = "# measured\ndistance;level;alignment\n0;1e-3;0\n0.5;0;1e-3\n1.0;-1e-3;0\n"
    from scipy.io import netcdf_file

    made = io.BytesIO()
    file = netcdf_file(made, "w")
    file.createDimension("distance", 3)
    for name in ("distance", "level"):
        file.createVariable(name, "f8", ("distance",))[:] = np.arange(3.0) * 1e-3
    file.flush()
    return [rails.encode(), track.encode(), made.getvalue()]


def _case_seeds() -> list[bytes]:
    return [
        b'[run]\nline = "HD"\nspeed = 300\ndistance = 20.0\nuntil_steady = false\nout = "a.nc"\n'
        b'[set]\ntrack.fastener.vertical_stiffness = 4e7\nvehicle."car_body".mass = 4e4\n'
    ]


def _sweep_seeds() -> list[bytes]:
    return [
        b'[run]\nline = "HD"\ndistance = 200\n[set]\ntrack.fastener.vertical_damping = 1e4\n'
        b"[grid]\nspeed = { start = 100, stop = 300, step = 20 }\n"
        b"track.fastener.vertical_stiffness = [40e6, 140e6]\n"
        b'[keep]\nnormal_force = ["max", "min"]\n[history]\n'
        b'variables = ["normal_force"]\nevery = 2\n',
        b'[run]\nline = "ZX"\n[[points]]\nspeed = 100\n[[points]]\nspeed = 120.5\n',
    ]


def _ssv_seeds() -> list[bytes]:
    space = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
    return [
        f'<?xml version="1.0"?><ssv:ParameterSet xmlns:ssv="{space}" version="1.0" name="a">'
        '<ssv:Parameters><ssv:Parameter name="b.c"><ssv:Real value="1.0" unit="m"/>'
        "</ssv:Parameter></ssv:Parameters></ssv:ParameterSet>".encode()
    ]


def _ssp_seeds() -> list[bytes]:
    space = "http://ssp-standard.org/SSP1/SystemStructureDescription"
    structure = (
        f'<?xml version="1.0"?><ssd:SystemStructureDescription xmlns:ssd="{space}" version="1.0" '
        'name="a"><ssd:System name="b"><ssd:ParameterBindings><ssd:ParameterBinding '
        'source="c.ssv"/></ssd:ParameterBindings><ssd:Elements><ssd:Component name="track" '
        'source="resources/t.fmu" type="application/x-fmu-sharedlibrary"/></ssd:Elements>'
        '<ssd:Connections><ssd:Connection startElement="track" startConnector="x" '
        'endElement="vehicle" endConnector="x"/></ssd:Connections></ssd:System>'
        "</ssd:SystemStructureDescription>"
    ).encode()
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        archive.writestr("SystemStructure.ssd", structure)
        archive.writestr("resources/t.fmu", _archive(_description_seeds()[0], _DESCRIPTION))
    return [structure, made.getvalue()]


_DESCRIPTION = "modelDescription.xml"


def _description_seeds() -> list[bytes]:
    return [
        b'<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0" modelName="a" guid="{1}">'
        b'<CoSimulation modelIdentifier="a" canGetAndSetFMUstate="true"/><UnitDefinitions>'
        b'<Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions><ModelVariables>'
        b'<ScalarVariable name="x" valueReference="0" causality="input" variability="continuous">'
        b'<Real start="0" unit="m"/></ScalarVariable><ScalarVariable name="n" valueReference="0" '
        b'causality="parameter" variability="fixed"><Integer start="1" min="0" max="5"/>'
        b"</ScalarVariable></ModelVariables><ModelStructure/></fmiModelDescription>"
    ]


def _state_seeds() -> list[bytes]:
    values = {"a": np.arange(6.0).reshape(2, 3), "b": 1.5, "c": 3, "d": True, "e": "text"}
    made = FmuState(model_hash="ab" * 32, variable_count=3, mode="running", time=0.5, values=values)
    return [to_bytes(made)]


TARGETS = {
    "profile": Target(profile, _profile_seeds),
    "irregularity": Target(irregularity, _irregularity_seeds),
    "case": Target(case, _case_seeds),
    "sweep": Target(sweep, _sweep_seeds),
    "ssv": Target(ssv, _ssv_seeds),
    "ssp": Target(ssp, _ssp_seeds),
    "description": Target(description, _description_seeds),
    "state": Target(state, _state_seeds),
}

os.environ.setdefault("RAIL_COSIM_CACHE", _FOLDER.name)


def mutants(seed: bytes, count: int) -> Iterator[bytes]:
    """Yield damaged copies: bytes changed, cut out, doubled, or put in; the same in every run."""
    rng = np.random.default_rng(len(seed))
    tokens = [
        b"\0",
        b"\xff",
        b"nan",
        b"1e999",
        b"-1",
        b'"',
        b"[",
        b"=",
        b"\n",
        b"<",
        b"&a;",
        b"9" * 30,
    ]
    for _ in range(count):
        data = bytearray(seed)
        for _ in range(int(rng.integers(1, 4))):
            at, way = int(rng.integers(0, len(data) + 1)), int(rng.integers(0, 5))
            end = min(len(data), at + int(rng.integers(1, 20)))
            if way == 0 and at < len(data):
                data[at] = int(rng.integers(0, 256))
            elif way == 1:
                del data[at:end]
            elif way == 2:
                data[at:at] = data[at:end]
            elif way == 3:
                data[at:at] = tokens[int(rng.integers(0, len(tokens)))]
            else:
                data[at:end] = tokens[int(rng.integers(0, len(tokens)))]
        yield bytes(data)

r"""The complete state of a slave, in memory and as bytes.

Layout of the bytes (little-endian)::

    8   magic  b"RAILFMU\0"
    4   format version
    4   number of variables of all kinds
    32  model hash: sources, table of variables and model name (SHA-256)
    8   length of the header
    .   header, JSON in UTF-8: mode, time, entries with name, type and shape
    .   the entries' values, one after the other
    32  SHA-256 of everything before

No code can be hidden in it: only numbers and text are read back.
"""

import copy
import dataclasses
import functools
import hashlib
import json
import math
import re
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np

from rail_fmi.errors import StateError

MAGIC = b"RAILFMU\0"
FORMAT_VERSION = 1

_HEAD = struct.Struct("<8sII32sQ")
_DIGEST_SIZE = hashlib.sha256().digest_size
_DTYPE = re.compile(r"[<|][biufc]\d{1,2}")
_SCALARS: dict[str, type] = {"int": int, "bool": bool, "str": str}

Value = np.ndarray | float | int | bool | str


@dataclasses.dataclass(frozen=True, kw_only=True)
class FmuState:
    """A copy of everything that a run depends on.

    Attributes
    ----------
    model_hash
        Hash of the model that made it, as hexadecimal text.
    variable_count
        Number of variables of all kinds.
    mode, time, error
        Where in its life the slave was, the end of the last step in s, and
        the held error's text (empty for none).
    values
        Flat dictionary of arrays and scalars: variables and model state.
    refusal
        Why the bytes could not be read; empty for a good state. Reading must
        not raise (the FMU would crash in the host), so a bad state is refused
        when it is set.
    """

    model_hash: str
    variable_count: int
    mode: str = ""
    time: float = 0.0
    error: str = ""
    values: Mapping[str, Value] = dataclasses.field(default_factory=dict)
    refusal: str = ""

    @functools.cached_property
    def serialized(self) -> bytes:
        """The state as bytes; kept, because hosts ask for the size first."""
        return to_bytes(self)


def copied(values: Mapping[str, Any]) -> dict[str, Value]:
    """Return copies of a flat dictionary of arrays and scalars.

    Raises
    ------
    StateError
        For a name that is not text or a value that is neither a number, text,
        nor an array of numbers.
    """
    result: dict[str, Value] = {}
    for name, value in values.items():
        if not isinstance(name, str):
            raise StateError(f"state entry {name!r}: the name must be text")
        if isinstance(value, np.generic):
            value = value.item()
        if isinstance(value, np.ndarray):
            if value.dtype.kind not in "biufc":
                raise StateError(f"state entry {name}: arrays of {value.dtype} cannot be saved")
            value = value.copy(order="K")
        elif not isinstance(value, float | int | bool | str):
            raise StateError(
                f"state entry {name}: {type(value).__name__} cannot be saved; "
                "give an array, a number or text"
            )
        result[name] = copy.copy(value)
    return result


def _packed(name: str, value: Value) -> tuple[dict[str, Any], bytes]:
    entry: dict[str, Any] = {"name": name}
    if isinstance(value, np.ndarray):
        order = "F" if value.flags.f_contiguous and not value.flags.c_contiguous else "C"
        dtype = value.dtype.newbyteorder("<")
        entry |= {"type": "array", "dtype": dtype.str, "shape": list(value.shape), "order": order}
        return entry, value.astype(dtype, copy=False).tobytes(order=order)
    if isinstance(value, float):
        return entry | {"type": "float"}, struct.pack("<d", value)
    kind = "bool" if isinstance(value, bool) else "int" if isinstance(value, int) else "str"
    return entry | {"type": kind, "value": value}, b""


def to_bytes(state: FmuState) -> bytes:
    """Return a state as bytes; the same state gives the same bytes."""
    packed = [_packed(name, value) for name, value in state.values.items()]
    header = json.dumps(
        {
            "mode": state.mode,
            "time": float(state.time).hex(),
            "error": state.error,
            "entries": [entry for entry, _ in packed],
        }
    ).encode()
    head = _HEAD.pack(
        MAGIC,
        FORMAT_VERSION,
        state.variable_count,
        bytes.fromhex(state.model_hash),
        len(header),
    )
    body = b"".join([head, header, *(blob for _, blob in packed)])
    return body + hashlib.sha256(body).digest()


def from_bytes(data: bytes) -> FmuState:
    """Return the state that :func:`to_bytes` wrote.

    Raises
    ------
    StateError
        If the bytes are not a state, have another format version or are damaged.
    """
    if len(data) < _HEAD.size + _DIGEST_SIZE or not data.startswith(MAGIC):
        raise StateError("these bytes are not a saved state of a rail_fmi slave")
    magic_size = len(MAGIC)
    (version,) = struct.unpack_from("<I", data, magic_size)
    if version != FORMAT_VERSION:
        raise StateError(
            f"the state has format version {version}, this FMU reads {FORMAT_VERSION}; "
            "save it again with this version"
        )
    body, digest = data[:-_DIGEST_SIZE], data[-_DIGEST_SIZE:]
    if hashlib.sha256(body).digest() != digest:
        raise StateError("the saved state is damaged: its SHA-256 does not match its contents")
    _, _, variable_count, model_hash, header_size = _HEAD.unpack_from(body)
    try:
        header = json.loads(body[_HEAD.size : _HEAD.size + header_size])
        return FmuState(
            model_hash=model_hash.hex(),
            variable_count=variable_count,
            mode=str(header["mode"]),
            time=float.fromhex(header["time"]),
            error=str(header["error"]),
            values=_unpacked(header["entries"], body, _HEAD.size + header_size),
        )
    except (
        KeyError, TypeError, ValueError, OverflowError, RecursionError, struct.error
    ) as error:  # fmt: skip
        raise StateError(f"the saved state cannot be read: {error}") from error


def _unpacked(entries: list[dict[str, Any]], body: bytes, offset: int) -> dict[str, Value]:
    values: dict[str, Value] = {}
    for entry in entries:
        name, kind = entry["name"], entry["type"]
        if kind == "array":
            # Numpy's own reading of types is a language; here they have one letter and a size.
            if not _DTYPE.fullmatch(entry["dtype"]):
                raise StateError(f"state entry {name}: arrays of {entry['dtype']} are not allowed")
            dtype = np.dtype(entry["dtype"])
            shape = tuple(int(length) for length in entry["shape"])
            if min(shape, default=0) < 0:
                raise StateError(f"state entry {name}: an array cannot have the shape {shape}")
            count = math.prod(shape)
            flat = np.frombuffer(body, dtype, count, offset)
            native = flat.astype(dtype.newbyteorder("="))
            values[name] = native.reshape(shape, order=entry["order"])
            offset += count * dtype.itemsize
        elif kind == "float":
            (values[name],) = struct.unpack_from("<d", body, offset)
            offset += 8
        else:
            values[name] = _SCALARS[kind](entry["value"])
    if offset != len(body):
        raise StateError("the saved state has bytes left over")
    return values

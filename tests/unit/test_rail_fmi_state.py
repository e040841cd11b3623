"""States as bytes: the same bits back, everything else refused."""

import dataclasses
import hashlib
import struct

import numpy as np
import pytest
from rail_fmi import StateError
from rail_fmi.state import FmuState, copied, from_bytes, to_bytes

STATE = FmuState(
    model_hash="ab" * 32,
    variable_count=7,
    mode="running",
    time=0.1 + 0.2,
    error="über 100 %",
    values={
        "matrix": np.arange(12.0).reshape(3, 4) / 7.0,
        "columns": np.asfortranarray(np.arange(6, dtype=np.float32).reshape(2, 3)),
        "empty": np.zeros((0, 3)),
        "scalar": np.array(2.5),
        "count": np.array([1, -(2**62)]),
        "flags": np.array([True, False]),
        "complex": np.array([1.0 + 2.0j]),
        "special": np.array([np.nan, -np.inf, -0.0, 5e-324]),
        "float": -0.0,
        "int": 2**70,
        "bool": True,
        "text": "Gleis\n\0 %",
    },
)


def test_bits_types_and_order_come_back():
    found = from_bytes(to_bytes(STATE))
    assert dataclasses.replace(found, values={}) == dataclasses.replace(STATE, values={})
    assert list(found.values) == list(STATE.values)
    for name, wanted in STATE.values.items():
        value = found.values[name]
        assert type(value) is type(wanted), name
        if isinstance(wanted, np.ndarray):
            assert (value.dtype, value.shape) == (wanted.dtype, wanted.shape), name
            assert value.tobytes() == wanted.tobytes(), name
            assert value.flags.f_contiguous == wanted.flags.f_contiguous, name
            assert value.flags.writeable, name
        elif isinstance(wanted, float):
            assert struct.pack("d", value) == struct.pack("d", wanted)
        else:
            assert value == wanted


def test_every_damaged_bit_is_seen():
    data = to_bytes(STATE)
    for place in range(len(data)):
        bad = bytearray(data)
        bad[place] ^= 1 << (place % 8)
        with pytest.raises(StateError):
            from_bytes(bytes(bad))


@pytest.mark.parametrize("data", [b"", b"RAILFMU\0", b"x" * 500, to_bytes(STATE)[:-1]])
def test_other_bytes_are_refused(data):
    with pytest.raises(StateError, match=r"not a saved state|damaged"):
        from_bytes(data)


def signed(body: bytes) -> bytes:
    return body + hashlib.sha256(body).digest()


def test_another_format_version_is_refused_by_number():
    body = to_bytes(STATE)[:-32]
    with pytest.raises(StateError, match="format version 9, this FMU reads 1"):
        from_bytes(signed(body[:8] + struct.pack("<I", 9) + body[12:]))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b'"<f8"', b'"|O8"'),
        (b'"array"', b'"pickl"'),
        (b'"<f8"', b'"(<f"'),
        (b'"<f8"', b'"f8,"'),
        (b"[3, 4]", b"[9, 9]"),
        (b"[3, 4]", b"[-1, ]"),
        (b"[3, 4]", b"[1e999]"),
        (b"[3, 4]", b"-3    "),
        (b'"mode"', b'"mood"'),
    ],
)
def test_consistently_forged_contents_are_refused(old, new):
    body = to_bytes(STATE)[:-32]
    with pytest.raises(StateError):
        from_bytes(signed(body.replace(old, new, 1)))


def test_copies_are_independent():
    array = np.ones(3)
    copy = copied({"a": array, "n": np.int64(3)})
    array[0] = 5.0
    assert copy["a"].tolist() == [1.0, 1.0, 1.0]
    assert type(copy["n"]) is int


@pytest.mark.parametrize("value", [None, [1.0], {"a": 1}, object(), np.array([object()])])
def test_values_that_cannot_be_saved_are_refused_by_name(value):
    with pytest.raises(StateError, match="state entry bad"):
        copied({"bad": value})

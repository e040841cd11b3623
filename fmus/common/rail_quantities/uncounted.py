"""Arrays in compiled code whose references are not counted.

Numba counts the references to every array, also where a row is cut out or handed on to another
function: two calls and two atomic operations of some 20 clock cycles each, and the compiler can
carry nothing across them. That was a fifth of a macro step. Arrays of the caller live longer than
the call, so functions that make none need no counting: they are compiled with :data:`UNCOUNTED`.
Functions that make arrays cannot be compiled so, nor those that return a part of one; numba says
so. Small arrays of a function's own have room on its stack.
"""

from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.registry import cpu_target
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)

from rail_quantities.kept_code import with_checksums

UNCOUNTED: dict[str, Any] = {"_nrt": False}
"""Options of ``numba.njit`` for functions that make no arrays."""

COUNTED: dict[str, Any] = {"_nrt": True}
"""Options for functions that do, to be said where functions without counting call them."""


class ReferenceType(types.Type):
    """Numba's type of a :class:`Reference` to a named tuple of the type ``parts``."""

    def __init__(self, parts: Any) -> None:
        self.parts = parts
        super().__init__(name=f"Reference({parts})")


class Reference:
    """A named tuple, which may hold others and arrays, as one argument for compiled code.

    Compiled code reads its fields by their names. What is read must not be changed meanwhile, but
    for the contents of arrays.

    Parameters
    ----------
    parts
        The named tuple; it is kept.

    Attributes
    ----------
    address
        Where its fields lie in memory, as numba has them.
    """

    def __init__(self, parts: Any) -> None:
        self.parts = parts
        kind: Any = numba.typeof(parts)
        context: Any = cpu_target.target_context
        size = context.get_abi_sizeof(context.get_value_type(kind))
        self._room = np.empty(-(-size // 8))
        self.address = self._room.ctypes.data
        self._numba_type_ = ReferenceType(kind)
        _store(parts, self.address)


@typeof_impl.register(Reference)
def _type_of(value: Any, _context: Any) -> Any:
    return value._numba_type_


register_model(ReferenceType)(models.OpaqueModel)


@unbox(ReferenceType)
def _unbox(_kind: Any, value: Any, at: Any) -> Any:
    number = at.pyapi.object_getattr_string(value, "address")
    address = at.pyapi.long_as_voidptr(number)
    at.pyapi.decref(number)
    return NativeValue(address)


@infer_getattr
class _Fields(AttributeTemplate):
    key = ReferenceType

    def generic_resolve(self, kind: Any, name: str) -> Any:
        parts = kind.parts
        return parts.types[parts.fields.index(name)] if name in parts.fields else None


@lower_getattr_generic(ReferenceType)
def _read(context: Any, builder: Any, kind: Any, address: Any, name: str) -> Any:
    whole = context.get_value_type(kind.parts)
    fields = builder.bitcast(address, whole.as_pointer())
    value = builder.load(cgutils.gep_inbounds(builder, fields, 0, kind.parts.fields.index(name)))
    value.set_metadata("invariant.load", builder.module.add_metadata([]))
    return value


def _make_put(typing: Any, value: Any, address: Any) -> Any:
    """Write a value to an address."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        given, where = arguments
        builder.store(given, builder.inttoptr(where, given.type.as_pointer()))
        return context.get_dummy_value()

    return types.void(value, types.int64), generate


_put: Any = intrinsic(_make_put)


_ENTRY: dict[str, Any] = {"cache": True, "no_cfunc_wrapper": True, **UNCOUNTED}


@with_checksums
@numba.njit(**_ENTRY)
def _store(parts: Any, address: Any) -> None:
    _put(parts, address)


def _disown(array: Any) -> None:
    for name in ("meminfo", "parent"):
        setattr(array, name, ir.Constant(getattr(array, name).type, None))


def _is_contiguous(array: Any) -> bool:
    return isinstance(array, types.Array) and array.layout == "C"


def _make_shaped(typing: Any, array: Any, first: Any, shape: Any) -> Any:
    """Return the part of a contiguous array from the place ``first`` on in a shape."""
    if not _is_contiguous(array):
        return None
    kind = types.Array(array.dtype, len(shape), "C")

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = context.make_array(array)(context, builder, value=arguments[0])
        data = builder.gep(source.data, [arguments[1]])
        sizes = cgutils.unpack_tuple(builder, arguments[2])
        return _view(context, builder, kind, data, sizes)

    return kind(array, types.int64, types.UniTuple(types.int64, len(shape))), generate


def _make_flat(typing: Any, array: Any) -> Any:
    """Return all of a contiguous array in one row."""
    if not _is_contiguous(array):
        return None
    kind = types.Array(array.dtype, 1, "C")

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = context.make_array(array)(context, builder, value=arguments[0])
        return _view(context, builder, kind, source.data, [source.nitems])

    return kind(array), generate


def _view(context: Any, builder: Any, kind: Any, data: Any, sizes: Any) -> Any:
    """Build an array over memory that is not its own."""
    word = ir.IntType(64)
    array = context.make_array(kind)(context, builder)
    size = ir.Constant(word, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
    strides, count = [], ir.Constant(word, 1)
    for length in reversed(sizes):
        strides.insert(0, builder.mul(size, count))
        count = builder.mul(count, length)
    array.data, array.itemsize, array.nitems = data, size, count
    array.shape = cgutils.pack_array(builder, sizes)
    array.strides = cgutils.pack_array(builder, strides)
    _disown(array)
    return array._getvalue()


def _make_on_stack(typing: Any, count: Any) -> Any:
    """Return an array of so many float64 (a number in the source) on the function's stack.

    It holds anything at first, and must not leave the function that makes it.
    """
    if not isinstance(count, types.IntegerLiteral):
        return None
    kind = types.Array(types.float64, 1, "C")

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        length = ir.Constant(ir.IntType(64), count.literal_value)
        data = cgutils.alloca_once(builder, ir.DoubleType(), size=length)
        return _view(context, builder, kind, data, [length])

    return kind(count), generate


shaped: Any = intrinsic(_make_shaped)
flat: Any = intrinsic(_make_flat)
on_stack: Any = intrinsic(prefer_literal=True)(_make_on_stack)

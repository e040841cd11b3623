"""Arrays in compiled code whose references are not counted.

Numba counts the references to every array, also where a row is cut out or handed on to another
function, each time with an atomic operation of some 20 clock cycles; and every array that a
function makes is allocated and freed. Together that was a seventh of a macro step. Arrays of the
caller live longer than the call, so in there they need no counting; small ones of a function's own
have room on its stack.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


def _make_borrowed(typing: Any, value: Any) -> Any:
    """Return an array, or a tuple with arrays in it, without what references are counted in.

    The caller must keep a reference to the original as long as it is used, or parts of it. So it is
    for arguments, never for arrays that the compiled function makes itself.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _strip(context, builder, value, arguments[0])

    return value(value), generate


def _strip(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value=value)
        _disown(array)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        kinds: Any = kind
        parts = [
            _strip(context, builder, part, builder.extract_value(value, place))
            for place, part in enumerate(kinds)
        ]
        return context.make_tuple(builder, kind, parts)
    return value


def _disown(array: Any) -> None:
    for name in ("meminfo", "parent"):
        setattr(array, name, ir.Constant(getattr(array, name).type, None))


def _is_contiguous(array: Any) -> bool:
    return isinstance(array, types.Array) and array.layout == "C"


def _make_shaped(typing: Any, array: Any, first: Any, shape: Any) -> Any:
    """Return the part of a contiguous array from the place ``first`` on in a shape.

    Its references are not counted, as with :func:`borrowed`.
    """
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
    """Return all of a contiguous array in one row, as :func:`borrowed`."""
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


borrowed: Any = intrinsic(_make_borrowed)
shaped: Any = intrinsic(_make_shaped)
flat: Any = intrinsic(_make_flat)
on_stack: Any = intrinsic(prefer_literal=True)(_make_on_stack)

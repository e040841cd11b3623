"""Arrays in compiled code that are not counted.

Numba counts the references to every array, also where a row is cut out or handed on to another
function, each time with an atomic operation of some 20 clock cycles. In the step of the track that
was a tenth of the time. Arrays from the caller live longer than the call: in there they need no
counting.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


def _make_borrowed(typing: Any, value: Any) -> Any:
    """Return an array, or a tuple with arrays in it, without what numba counts references in.

    The caller must keep a reference to the original as long as it is used, or parts of it. So it is
    for arguments, never for arrays that the compiled function makes itself.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _strip(context, builder, value, arguments[0])

    return value(value), generate


def _strip(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value=value)
        for name in ("meminfo", "parent"):
            none = ir.Constant(getattr(array, name).type, None)
            setattr(array, name, none)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        parts = [
            _strip(context, builder, part, builder.extract_value(value, place))
            for place, part in enumerate(kind)
        ]
        return context.make_tuple(builder, kind, parts)
    return value


borrowed: Any = intrinsic(_make_borrowed)

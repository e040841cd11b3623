"""What protects the host: text that its logger can print, and cheap calls from its threads."""

import ctypes
import threading
from collections.abc import Sequence

_THREAD_LIMIT = 64
_kept_threads: set[int] = set()


def printable(message: str) -> str:
    """Return a message that pythonfmu can hand to the host's logger.

    The FMI logger takes it as a ``printf`` format, so ``%`` is doubled; text
    that is not UTF-8 or holds NUL would crash the C++ layer or end there.
    """
    return encodable(message).replace("\0", "\\0").replace("%", "%%")


def encodable(text: str) -> str:
    """Return ``text`` with what UTF-8 cannot express written as ``\\udc..``."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def keep_thread_state() -> None:
    """Keep the Python thread state of the calling thread until the process ends.

    In a host that is not Python, ``PyGILState_Ensure`` of every FMI call makes
    a thread state and the release deletes it, at some 10 us per call. One
    extra reference keeps it. The number of threads served so is bounded,
    because the state of a thread that ends is not given back.
    """
    ident = threading.get_ident()
    if ident not in _kept_threads and len(_kept_threads) < _THREAD_LIMIT:
        _kept_threads.add(ident)
        ctypes.pythonapi.PyGILState_Ensure()


def texts_from_host(values: Sequence[str]) -> list[str]:
    """Return the texts of ``fmi2SetString``; one that is not UTF-8 is refused.

    pythonfmu leaves a null pointer in the list for such a text, and an error
    pending: touching either from Python would crash.

    Raises
    ------
    ValueError
        If a text is not UTF-8.
    """
    get_item = ctypes.pythonapi.PyList_GetItem
    get_item.restype = ctypes.c_void_p
    get_item.argtypes = [ctypes.py_object, ctypes.c_ssize_t]
    if any(get_item(values, i) is None for i in range(len(values))):
        raise ValueError("a text given by fmi2SetString is not UTF-8")
    return list(values)

"""What protects the host: text that its logger can print, and cheap calls from its threads."""

import _ctypes
import contextlib
import ctypes
import os
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

_THREAD_LIMIT = 64
_kept_threads: set[int] = set()
_settled_libraries: set[str] = set()

forget_pending_error = ctypes.pythonapi.PyErr_Clear
forget_pending_error.restype = None


def printable(message: str) -> str:
    """Return a message that pythonfmu can hand to the host's logger.

    The FMI logger takes it as a ``printf`` format, so ``%`` is doubled; text
    that is not UTF-8 or holds NUL would crash the C++ layer or end there.
    """
    return encodable(message).replace("\0", "\\0").replace("%", "%%")


def encodable(text: str) -> str:
    r"""Return ``text`` with what UTF-8 cannot express written as ``\udc..``."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def logging_is_on(logger: int) -> bool:
    """Return whether the host's logger gets all messages of an instance.

    Parameters
    ----------
    logger
        Address of pythonfmu's ``PyLogger``, which an instance is given: a virtual table, the
        flag, the instance name, and the vector of categories to which messages are limited.
    """
    if not sys.platform.startswith("linux"):
        return False  # not tried; then the text is on stderr too
    on = ctypes.c_bool.from_address(logger + 8).value
    first, last = (ctypes.c_void_p * 2).from_address(logger + 48)
    return on and first == last


def tell_on_stderr(text: str) -> None:
    """Write a text to stderr, if there is one; a program without a console has none."""
    with contextlib.suppress(Exception):
        print(encodable(text), file=sys.stderr, flush=True)


def add_references(*objects: object) -> None:
    """Take one more reference to each object, which C++ code gives back."""
    for thing in objects:
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(thing))


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


def settle_library(resources: str, model_identifier: str) -> None:
    """Let the FMU's library be unloaded without a double free (Linux).

    pythonfmu 0.7 destroys its ``PyState`` twice when the library is unloaded
    or the process ends: as a static object and again in
    ``onLibraryUnload``, on freed memory. Its own
    ``finalizePythonInterpreter`` before that makes both harmless. In a Python
    process the object has nothing to do, so that is done at once. Elsewhere it
    ends the interpreter, so it is left to the end of the process, before the
    static objects go.
    """
    path = Path(resources).parent / "binaries" / "linux64" / f"{model_identifier}.so"
    if not sys.platform.startswith("linux") or str(path) in _settled_libraries:
        return
    try:
        library = ctypes.CDLL(str(path), mode=os.RTLD_NOLOAD | os.RTLD_NOW)
        finalize = library.finalizePythonInterpreter
    except (OSError, AttributeError):
        return  # loaded from another place, or another pythonfmu
    if sys.orig_argv:  # Python was started as a program
        finalize()
        _ctypes.dlclose(library._handle)
    else:  # the handle stays open, so that the function is there at the end
        _settled_libraries.add(str(path))
        ctypes.CDLL(None).__cxa_atexit(ctypes.cast(finalize, ctypes.c_void_p), None, None)


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

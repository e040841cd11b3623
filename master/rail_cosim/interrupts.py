"""Ctrl-C during a run: finish the step, keep the records.

Slaves in Python run in the master's own interpreter. The usual
``KeyboardInterrupt`` would strike inside such a slave, whose host library
takes it for a fatal error; so the signal only leaves a note here, and the
master looks for it between two calls.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Iterator
from multiprocessing import resource_tracker
from types import FrameType, TracebackType
from typing import Self

EXIT_STATUS = 130


class InterruptNote:
    """Context manager in which Ctrl-C sets ``requested`` and does nothing else.

    The second one ends the process at once, for a slave that does not come
    back. Outside of the main thread signals cannot be taken: it then does nothing.

    Attributes
    ----------
    requested
        Whether the user wants to stop.
    """

    def __init__(self) -> None:
        self.requested = False
        self._previous = None
        self._installed = False

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            self._previous = signal.signal(signal.SIGINT, self._note)
            self._installed = True
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._installed:
            signal.signal(signal.SIGINT, self._previous)

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self.requested:
            os._exit(EXIT_STATUS)
        self.requested = True

    def check(self) -> None:
        """Raise ``KeyboardInterrupt`` here, where it does no harm, if one was asked for."""
        if self.requested:
            raise KeyboardInterrupt


@contextlib.contextmanager
def without_interrupts() -> Iterator[None]:
    """Start processes and threads in here that Ctrl-C does not reach.

    A terminal sends it to all processes of a command; only this one is to say something. One
    that comes meanwhile strikes at the end. Windows knows no signal masks: nothing is done.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # it would unmask the thread that starts it
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

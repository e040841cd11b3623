"""What an FMU instance says through its logger."""

from __future__ import annotations

import itertools
import re
from collections import deque

from rail_cosim.slave import Message, Status

_KEPT = 1000
_REPORTED = 5
_WRAPPING = re.compile(r"^Fatal py exception encountered: \[\w+\] \w+\n")  # by pythonfmu
_numbers = itertools.count(1)
_logs: dict[int, Log] = {}


class Log:
    """The messages of one instance.

    Attributes
    ----------
    number
        Identifies the instance: handed to the FMU as ``componentEnvironment``.
    """

    def __init__(self) -> None:
        self.number = next(_numbers)
        self._messages: deque[Message] = deque(maxlen=_KEPT)
        self._new_warnings: list[str] = []
        self._seen: set[str] = set()
        _logs[self.number] = self

    def add(self, status: int, text: str) -> None:
        """Keep one message."""
        known = Status(status) if status in list(Status) else Status.ERROR
        text = _WRAPPING.sub("", text).strip()
        self._messages.append(Message(status=known, text=text))
        if known is Status.WARNING and text not in self._seen:
            self._seen.add(text)
            self._new_warnings.append(text)

    def problems(self) -> list[Message]:
        """Return the last few messages that are worse than a warning, each text once.

        An FMU that marks none of its messages so still said something: then
        the last message of any kind.
        """
        worse = [m for m in self._messages if m.status not in (Status.OK, Status.WARNING)]
        different = list({message.text: message for message in worse}.values())
        return different[-_REPORTED:] or list(self._messages)[-1:]

    def take_warnings(self) -> list[str]:
        """Return the warnings that were not returned before."""
        taken, self._new_warnings = self._new_warnings, []
        return taken

    def close(self) -> None:
        """Take no more messages."""
        _logs.pop(self.number, None)


def deliver(number: int | None, status: int, text: bytes | None) -> bool:
    """Hand a message to the log with this number; return whether there is one."""
    log = _logs.get(number or 0)
    if log is None:
        return False
    log.add(status, (text or b"").decode("utf-8", errors="replace"))
    return True

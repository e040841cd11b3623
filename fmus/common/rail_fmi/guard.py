"""What stands between a slave and its host: log, held errors, and no exception."""

import sys
import threading
import traceback
from collections.abc import Callable
from typing import Any

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status
from rail_quantities import ParameterError

from rail_fmi import host
from rail_fmi.errors import RailFmiError

_EXPECTED = (RailFmiError, ParameterError)


class CallError(Exception):
    """What pythonfmu's C++ layer turns into a status of error; ``repr`` is what it logs."""

    def __repr__(self) -> str:
        return str(self)


class GuardedSlave(Fmi2Slave):
    """A slave whose errors are held, told, and end the host's call with a status of error.

    The C++ layer of pythonfmu 0.7 knows one way to such a status: an exception,
    which gives ``fmi2Fatal`` with its text. It gives back its references to the
    instance then and again at the end, so one more of each is taken before.
    Used without a host, from Python, a slave raises nothing and holds its error.
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._logger: int = kwargs.get("logger", 0)
        self._early_log: list[Any] | None = []
        self._thread = 0
        self._run_error = self._setup_error = self._last_logged = ""

    @property
    def held_error(self) -> str:
        """Why steps are refused; empty while all is well."""
        return self._run_error or self._setup_error

    def _publish_status(self) -> None:
        """Make :attr:`held_error` known to the host."""

    def info(self, text: str) -> None:
        """Log a message for the user; seen only with logging on."""
        self.log(text)

    def warn(self, text: str) -> None:
        """Log a warning, which goes to stderr if the host has logging off."""
        self.log(text, Fmi2Status.warning)

    def log(
        self,
        msg: str,
        status: Fmi2Status = Fmi2Status.ok,
        category: str | None = None,
        debug: Any = None,
    ) -> None:
        """Log a message; any text is safe."""
        if status != Fmi2Status.ok and self._logger and not host.logging_is_on(self._logger):
            who = f"{self.modelName} ({self.instance_name}): "
            host.tell_on_stderr(who + str(msg).removeprefix(who))
        super().log(host.printable(str(msg)), status, category)
        if self._early_log is not None:
            # A message left in the queue when the instance is freed crashes: it
            # goes there when a call has begun, which empties the queue at its end.
            self._early_log.append(self.log_queue.pop())

    def _enter(self) -> None:
        """Begin an FMI call on a thread that was not there before."""
        self._thread = threading.get_ident()
        host.keep_thread_state()
        if self._early_log is not None:
            self.log_queue.extend(self._early_log)
            self._early_log = None
            host.settle_library(self.resources or "", self.modelName or "")
            if self.resources in sys.path:  # put there by pythonfmu, at every instantiation
                sys.path.remove(self.resources)

    def _hold(self, error: BaseException, *, setup: bool = False) -> None:
        """Keep an error and log it, each text once."""
        text = str(error) if isinstance(error, _EXPECTED) else _described(error)
        text = host.encodable(f"{self.modelName} ({self.instance_name}): {text}")
        if setup:
            self._setup_error = text
        elif not self._run_error:
            self._run_error = text
        if text != self._last_logged:
            self._last_logged = text
            details = "" if isinstance(error, _EXPECTED) else _traceback(error)
            self.log(text + details, Fmi2Status.error)
        self._publish_status()

    def _refuse(self) -> None:
        """End the host's call with a status of error and what has been logged in it.

        The messages go with the exception: with one pending, the C++ layer may lose it
        over a queue that is not empty.
        """
        if not self._logger:
            return
        texts = [message.msg for message in self.log_queue]
        self.log_queue.clear()
        reason = host.printable(self.held_error)
        if not any(reason in text for text in texts):
            texts.append(reason)
        host.add_references(type(self), self, self.log_queue)
        raise CallError("\n".join(texts))

    def _guarded(self, work: Callable[[], Any], default: Any = None) -> Any:
        try:
            if threading.get_ident() != self._thread:
                self._enter()
            return work()
        except BaseException as error:
            self._hold(error)
        self._refuse()
        return default


def _described(error: BaseException) -> str:
    try:
        return f"{type(error).__name__}: {error}"
    except Exception:  # an error whose text cannot be made
        return type(error).__name__


def _traceback(error: BaseException) -> str:
    return "\n" + "".join(traceback.format_exception(error)).rstrip()

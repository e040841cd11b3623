"""What is told while a run goes on."""

from __future__ import annotations

import warnings
from typing import Protocol


class Reporter(Protocol):
    """What a run tells while it goes on."""

    def stage(self, text: str) -> None:
        """Say what is being done now."""
        ...

    def progress(self, done: int, planned: int) -> None:
        """Say how many macro steps are done."""
        ...

    def notice(self, text: str) -> None:
        """Pass on a warning of an FMU."""
        ...


class Quiet:
    """Reporter for scripts: notices are Python warnings, nothing else is said."""

    def stage(self, text: str) -> None:
        """Say nothing."""

    def progress(self, done: int, planned: int) -> None:
        """Say nothing."""

    def notice(self, text: str) -> None:
        """Warn."""
        warnings.warn(text, stacklevel=2)

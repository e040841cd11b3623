"""Errors of the vehicle model."""


class StepError(RuntimeError):
    """A step could not be made; the message says why and what to try."""

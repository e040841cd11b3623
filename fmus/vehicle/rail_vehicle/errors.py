"""Errors of the vehicle model."""


class StepError(RuntimeError):
    """A step could not be made; the message says why and what to try."""


class ExtrapolationError(StepError):
    """The contact forces turn from step to step: the coupling is unstable."""

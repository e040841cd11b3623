"""Errors of the FMI base."""


class RailFmiError(Exception):
    """Base of all errors of this package, except :class:`rail_quantities.ParameterError`."""


class TableError(RailFmiError, ValueError):
    """The table of variables contradicts itself or FMI 2.0."""


class StepError(RailFmiError, RuntimeError):
    """A step cannot be made; the run ends here. Raised by slaves and by the base."""


class StateError(RailFmiError, ValueError):
    """A saved state is damaged or belongs to another model."""


class BuildError(RailFmiError, RuntimeError):
    """An FMU could not be built."""

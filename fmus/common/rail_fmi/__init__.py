"""FMI 2.0 co-simulation base of the project's slaves.

One table of variables gives the FMI variables, the model description, the
checks, the states and the documentation. The package knows no physics.
:class:`RailSlave` needs ``pythonfmu`` and is imported on first use, so tables
and documents can be made without it.
"""

from typing import TYPE_CHECKING, Any

from rail_quantities import ParameterError

from rail_fmi.documentation import documentation_table
from rail_fmi.errors import BuildError, RailFmiError, StateError, StepError, TableError
from rail_fmi.variables import (
    KEEP_FIRST_INPUTS,
    Variable,
    VariableTable,
    parameter_variables,
)

if TYPE_CHECKING:
    from rail_fmi.slave import RailSlave

__version__ = "0.1.0"

__all__ = [
    "KEEP_FIRST_INPUTS",
    "BuildError",
    "ParameterError",
    "RailFmiError",
    "RailSlave",
    "StateError",
    "StepError",
    "TableError",
    "Variable",
    "VariableTable",
    "documentation_table",
    "parameter_variables",
]


def __getattr__(name: str) -> Any:
    if name == "RailSlave":
        from rail_fmi.slave import RailSlave

        return RailSlave
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

"""Parameters that describe themselves: unit, symbol, limits and meaning beside each value.

Every parameter set of the project is a frozen, keyword-only dataclass whose
fields are made with :func:`quantity`. From that one description come the
checks, the FMU's variables and the tables of the documentation. :func:`kept_array` keeps what
parameter sets take long to turn into. The package knows neither physics nor FMI.
"""

from rail_quantities.errors import ParameterError, UnknownParameterError, nearest
from rail_quantities.kept import kept_array
from rail_quantities.parameters import ParameterSet, flatten, with_values
from rail_quantities.quantity import Quantity, quantity

__all__ = [
    "ParameterError",
    "ParameterSet",
    "Quantity",
    "UnknownParameterError",
    "flatten",
    "kept_array",
    "nearest",
    "quantity",
    "with_values",
]

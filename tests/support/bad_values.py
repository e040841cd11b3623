"""Values that no one should give to a parameter, and what a core makes of them."""

import dataclasses
import math
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from rail_quantities import ParameterError, Quantity

NOT_NUMBERS = ("12", "", None, [1.0], {}, object(), 1j, True, math.nan, math.inf, -math.inf)
NOT_TEXTS = (1.0, None, b"HD", ["HD"], True)
NOT_TRUTHS = ("true", 1, 0.0, None)
MANTISSA = 1.0 + 2.0**-40
"""Just beyond a limit."""


@dataclasses.dataclass(frozen=True)
class Outcome:
    """What became of a value.

    ``kind`` is ``refused`` (by the parameter set), ``refused in set-up``, ``refused in a
    step`` or ``runs``; ``text`` the message; ``fault`` why this is not right, empty if it is.
    """

    kind: str
    text: str = ""
    fault: str = ""


def values_for(about: Quantity, default: Any) -> Iterator[Any]:
    """Yield values to try: of the wrong type, no numbers, small, large, and at the limits."""
    if isinstance(default, str):
        yield from NOT_TEXTS
        yield from ("", "no such word", "\0", "/", "ü" * 300)
        return
    if isinstance(default, bool):
        yield from NOT_TRUTHS
        return
    yield from NOT_NUMBERS
    whole = isinstance(default, int)
    if whole:
        yield from (0.5, 0, -1, 1, default + 1, 10**9, 2**40, -(2**31))
    else:
        scale = abs(default) or 1.0
        yield from (0.0, -scale, -1e300, 1e300, 5e-324, 1e-30, 1e30)
        yield from (scale * factor for factor in (1e-6, 1e-2, 1e2, 1e6))
    for limit in (about.above, about.at_least, about.below, about.at_most):
        if limit is not None:
            beyond = (limit - 1, limit, limit + 1)
            finer = (limit / MANTISSA, limit, limit * MANTISSA) if limit else (-1e-12,)
            yield from beyond if whole else finer


def outcome(
    name: str,
    value: Any,
    make: Callable[[], Any],
    run: Callable[[Any], np.ndarray],
    refusals: tuple[type[Exception], ...],
) -> Outcome:
    """Return what becomes of a value.

    Parameters
    ----------
    name, value
        The parameter.
    make
        Makes the parameter set.
    run
        Sets up and steps a core with it; returns what came out.
    refusals
        Errors with which a core refuses.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        try:
            parameters = make()
        except ParameterError as error:
            return Outcome("refused", str(error), _message_fault(name, value, error))
        except Exception as error:
            return Outcome("refused", fault=f"{type(error).__name__} in the check: {error}")
        try:
            results = run(parameters)
        except ParameterError as error:
            return Outcome("refused in set-up", str(error), _message_fault(name, value, error))
        except refusals as error:
            return Outcome(
                "refused in set-up or a step", str(error), "" if str(error) else "no text"
            )
        except Exception as error:
            return Outcome("failed", fault=f"{type(error).__name__}: {error}")
    fault = "" if np.isfinite(results).all() else "results are not finite"
    return Outcome("runs", fault=fault)


def _message_fault(name: str, value: Any, error: ParameterError) -> str:
    if error.name.rpartition(".")[2] not in str(error) or not error.limit:
        return f"the message names no parameter or limit: {error}"
    if error.name == name and repr(error.value) not in (repr(value), repr(float_of(value))):
        return f"the message gives another value: {error}"
    return ""


def float_of(value: Any) -> Any:
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return value


def counted(outcomes: dict[tuple[str, str], Outcome]) -> str:
    """Return the numbers of parameters, values and outcomes in a sentence."""
    kinds = Counter(found.kind for found in outcomes.values())
    names = {name for name, _ in outcomes}
    return f"{len(names)} parameters, {len(outcomes)} values: " + ", ".join(
        f"{count} {kind}" for kind, count in sorted(kinds.items())
    )

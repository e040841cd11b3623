"""Tables of the track's frequency view as JSON.

``python -m slab_track.frequency receptance --out receptance.json`` computes one; the others are
``p2`` and ``mode``. All values are in SI units, complex ones as objects with ``real`` and
``imag``.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from rail_quantities import ParameterError, ParameterSet, flatten, with_values

from slab_track.errors import TrackError
from slab_track.frequency.modes import WHEELSET_ON_PRIMARY, Wheelset
from slab_track.frequency.study import Table, mode_table, p2_table, receptance_table
from slab_track.parameters import TrackParameters
from slab_track.presets import LINES

_PROGRAM = "slab_track.frequency"
P = TypeVar("P", bound=ParameterSet)


def main(arguments: list[str] | None = None) -> int:
    """Run the command; return its exit status."""
    options = _parser().parse_args(arguments)
    try:
        track = apply_settings(LINES[options.line], options.track)
        wheelset = apply_settings(WHEELSET_ON_PRIMARY, options.wheelset)
        about, columns = _table(options.table, track, wheelset, options.quick)
    except ParameterError as error:
        print(f"{_PROGRAM}: error: {error}", file=sys.stderr)
        return 2
    except TrackError as error:
        print(f"{_PROGRAM}: error: {error}", file=sys.stderr)
        return 1
    used = {name: value for name, (_, value) in flatten(track).items()}
    data = {
        "about": about,
        "parameters": used,
        "columns": {name: _plain(values) for name, values in columns.items()},
    }
    options.out.write_text(json.dumps(data), encoding="utf-8")
    for name, value in about.items():
        print(f"{name} = {value:.6g}")
    return 0


def _table(name: str, track: TrackParameters, wheelset: Wheelset, quick: bool) -> Table:
    if name == "receptance":
        return receptance_table(track, quick=quick)
    compute = {"p2": p2_table, "mode": mode_table}[name]
    return compute(track, wheelset, quick=quick)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=f"python -m {_PROGRAM}",
        description="Receptances of the rail heads (receptance), P2 resonance over the stiffness "
        "of the pads (p2), shape of the coupled P2 mode (mode).",
    )
    add = parser.add_argument
    add("table", choices=("receptance", "p2", "mode"), help="what to compute")
    add("--line", default="HD", choices=tuple(LINES), help="parameter set of the track")
    repeated: dict[str, Any] = {"action": "append", "default": [], "metavar": "NAME=VALUE"}
    add("--track", help="a parameter of the track", **repeated)
    add("--wheelset", help="a parameter of the wheelset", **repeated)
    add("--quick", action="store_true", help="fewer points")
    add("--out", type=Path, required=True, help="JSON file to write")
    return parser


def apply_settings(parameters: P, texts: list[str]) -> P:
    """Return a copy with ``NAME=VALUE`` texts applied.

    Raises
    ------
    ParameterError
        For an unknown name, or a value that is not allowed.
    """
    known, values = flatten(parameters), {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals:
            raise ParameterError(name, "", "there is no value", f"write {name}=VALUE")
        default = known[name][1] if name in known else ""
        values[name] = _value(name, value, type(default))
    return with_values(parameters, values)


def _value(name: str, text: str, kind: type) -> Any:
    if kind is bool:
        if text.lower() not in ("true", "false"):
            raise ParameterError(name, text, "must be true or false")
        return text.lower() == "true"
    if kind in (int, float):
        try:
            return float(text)
        except ValueError:
            raise ParameterError(name, text, "must be a number") from None
    return text


def _plain(values: np.ndarray) -> Any:
    if np.iscomplexobj(values):
        return {"real": np.real(values).tolist(), "imag": np.imag(values).tolist()}
    return values.tolist()


if __name__ == "__main__":
    sys.exit(main())

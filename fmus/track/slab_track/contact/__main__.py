"""Table of the contact of a wheelset over its lateral displacement.

``python -m slab_track.contact --wheel S1002 --rail 60E1 --out contact.csv`` prints the table
and writes it to a CSV or JSON file, all columns in SI units.
"""

import argparse
import csv
import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
from rail_quantities import ParameterError

from slab_track.contact import (
    ContactGeometry,
    ContactParameters,
    ContactTable,
    contact_table,
    equivalent_conicity,
    load_profile,
)
from slab_track.parameters import Rail

_PROGRAM = "slab_track.contact"
_REACH = 8e-3  # m, lateral displacement to either side
_AMPLITUDE = 3e-3  # m, of the equivalent conicity
_SIDES = ("left", "right")
_MM, _MRAD = 1e3, 1e3


def main(arguments: list[str] | None = None) -> int:
    """Run the command; return its exit status."""
    options = _parser().parse_args(arguments)
    try:
        geometry = _geometry(options)
        lateral = np.linspace(-_REACH, _REACH, options.points)
        table = contact_table(geometry, lateral)
    except ParameterError as error:
        print(f"{_PROGRAM}: error: {error}", file=sys.stderr)
        return 2
    except ValueError:
        # No height or roll at which both wheels touch.
        print(
            f"{_PROGRAM}: error: a wheel finds no rail between -8 and 8 mm of lateral "
            f"displacement: gauge {options.gauge:g} m and rolling circles "
            f"{options.rolling_circle_distance:g} m apart do not fit each other",
            file=sys.stderr,
        )
        return 2
    columns, conicity, undefined = _columns(table), math.nan, ""
    try:
        conicity = equivalent_conicity(
            lateral, table.rolling_radius_difference, amplitude=_AMPLITUDE
        )
    except ParameterError as error:
        undefined = f"{error.limit}; {error.remedy}"
    _print(options, columns)
    said = f"not defined: {undefined}" if undefined else f"{conicity:.4f}"
    print(f"\nequivalent conicity at {_AMPLITUDE * _MM:g} mm: {said}")
    if options.out:
        _write(options, columns, conicity, undefined)
    return 0


def _parser() -> argparse.ArgumentParser:
    contact, rail = ContactParameters(), Rail()
    parser = argparse.ArgumentParser(
        prog="python -m slab_track.contact",
        description="Contact of a wheelset on its rails from -8 to 8 mm of lateral displacement.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--wheel", default=contact.wheel_profile, help="wheel profile, or its file")
    add("--rail", default=contact.rail_profile, help="rail profile, or its file")
    add("--gauge", type=float, default=rail.gauge, help="gauge, m")
    add("--depth", type=float, default=rail.gauge_measurement_depth, help="depth of the gauge, m")
    add("--cant", type=float, default=rail.cant, help="inclination of the rails (1:40 is 0.025)")
    add(
        "--rolling-circle-distance",
        type=float,
        default=contact.rolling_circle_distance,
        help="distance of the rolling circles, m",
    )
    add("--radius", type=float, default=contact.wheel_radius, help="wheel radius, m")
    add(
        "--penetration",
        type=float,
        default=1e-6,
        help="overlap over which a patch is averaged, m; 1e-6: rigid profiles, 7e-5: loaded",
    )
    add("--points", type=_count, default=65, help="number of lateral displacements")
    add("--out", type=_data_file, help="file to write, .csv or .json")
    return parser


def _count(text: str) -> int:
    number = int(text)
    if not 9 <= number <= 2001:
        raise argparse.ArgumentTypeError(f"{number}: must be from 9 to 2001")
    return number


def _data_file(text: str) -> Path:
    if Path(text).suffix.lower() not in (".csv", ".json"):
        raise argparse.ArgumentTypeError(f"{text}: must end in .csv or .json")
    return Path(text)


def _geometry(options: argparse.Namespace) -> ContactGeometry:
    """Return the geometry; the parameter classes check the values."""
    rail = Rail(gauge=options.gauge, gauge_measurement_depth=options.depth, cant=options.cant)
    contact = ContactParameters(
        rolling_circle_distance=options.rolling_circle_distance,
        wheel_radius=options.radius,
        reference_penetration=options.penetration,
    )
    placement = contact.placement(
        rail.gauge, rail.gauge_measurement_depth, rail.cant, rail.axis_depth
    )
    return ContactGeometry(
        load_profile("wheel", options.wheel),
        load_profile("rail", options.rail),
        placement,
        reference_penetration=contact.reference_penetration,
    )


def _columns(table: ContactTable) -> dict[str, np.ndarray]:
    """Return the table's columns by name, those of the wheels as left and right."""
    columns = {
        "lateral_displacement": table.lateral_displacement,
        "roll_angle": table.roll_angle,
        "vertical_displacement": table.vertical_displacement,
        "rolling_radius_difference": table.rolling_radius_difference,
    }
    for name in ("contact_angle", "wheel_position", "rail_position"):
        for k, side in enumerate(_SIDES):
            columns[f"{side}_{name}"] = getattr(table, name)[:, k]
    return columns


def _print(options: argparse.Namespace, columns: dict[str, np.ndarray]) -> None:
    print(
        f"{options.wheel} on {options.rail}, gauge {options.gauge * _MM:g} mm "
        f"{options.depth * _MM:g} mm below the heads, cant {options.cant:g}, rolling circles "
        f"{options.rolling_circle_distance * _MM:g} mm apart"
    )
    print("lateral displacement y and radius difference dr in mm, roll in mrad, contact angle in")
    print("degrees, contact point on wheel and rail in mm outwards; left wheel, then right wheel\n")
    print(f"{'y':>7} {'dr':>8} {'roll':>7}" + f" {'angle':>7} {'wheel':>7} {'rail':>7}" * 2)
    for i, y in enumerate(columns["lateral_displacement"]):
        numbers = [
            f"{y * _MM:7.2f}",
            f"{columns['rolling_radius_difference'][i] * _MM:8.3f}",
            f"{columns['roll_angle'][i] * _MRAD:7.3f}",
        ]
        for side in _SIDES:
            numbers += [
                f"{math.degrees(columns[f'{side}_contact_angle'][i]):7.2f}",
                f"{columns[f'{side}_wheel_position'][i] * _MM:7.2f}",
                f"{columns[f'{side}_rail_position'][i] * _MM:7.2f}",
            ]
        print(" ".join(numbers))


def _write(
    options: argparse.Namespace,
    columns: dict[str, np.ndarray],
    conicity: float,
    undefined: str,
) -> None:
    path: Path = options.out
    if path.suffix.lower() == ".csv":
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(columns)
            writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
        return
    about: dict[str, Any] = {k: v for k, v in vars(options).items() if k not in ("out", "points")}
    about |= {"equivalent_conicity": conicity, "conicity_amplitude": _AMPLITUDE}
    if undefined:
        about["equivalent_conicity_not_defined"] = undefined
    data = {"about": about, "columns": {name: c.tolist() for name, c in columns.items()}}
    path.write_text(json.dumps(data, indent=1), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())

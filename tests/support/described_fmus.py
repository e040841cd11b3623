"""Made-up FMUs that are a description only: what is declared is all that is looked at."""

import sys
import zipfile
from pathlib import Path

BINARY = {"win32": "win64/M.dll", "darwin": "darwin64/M.dylib"}.get(sys.platform, "linux64/M.so")
MOTION = {
    **dict.fromkeys(
        ("longitudinal_position", "lateral_displacement", "vertical_displacement"), "m"
    ),
    **dict.fromkeys(("roll_angle", "yaw_angle"), "rad"),
    **dict.fromkeys(("longitudinal_velocity", "lateral_velocity", "vertical_velocity"), "m/s"),
    **dict.fromkeys(("roll_rate", "yaw_rate", "pitch_rate"), "rad/s"),
}
FORCES = {
    **{f"contact.{way}_force": "N" for way in ("longitudinal", "lateral", "vertical")},
    **{f"contact.{way}_moment": "N.m" for way in ("roll", "pitch", "yaw")},
}
UNITS = {
    "m": 'm="1"',
    "rad": 'rad="1"',
    "m/s": 'm="1" s="-1"',
    "rad/s": 'rad="1" s="-1"',
    "N": 'kg="1" m="1" s="-2"',
    "N.m": 'kg="1" m="2" s="-2"',
}


def terminals(count, motion, forces):
    """Return ``{name: (causality, unit)}`` of the terminals."""
    return {
        f"wheelset[{i}].{name}": (causality, unit)
        for i in range(1, count + 1)
        for members, causality in ((MOTION, motion), (FORCES, forces))
        for name, unit in members.items()
    }


def vehicle(count=1):
    return terminals(count, "output", "input")


def track(count=1):
    return terminals(count, "input", "output") | {"wheelset_count": ("parameter", None, str(count))}


def scalar(number, name, causality, unit, start=None):
    """Return a ScalarVariable as the rules want it; no unit makes it an integer."""
    variability = ' variability="fixed"' if causality == "parameter" else ""
    if start is None and causality in ("input", "parameter"):
        start = "0"
    value = "" if start is None else f' start="{start}"'
    if unit is None:
        about = f"<Integer{value}/>"
    else:
        declared = f' unit="{unit}"' if unit else ""
        about = f"<Real{declared}{value}/>"
    head = f'name="{name}" valueReference="{number}" causality="{causality}"{variability}'
    return f"<ScalarVariable {head}>{about}</ScalarVariable>"


def xml(variables):
    rows = list(variables.items())
    scalars = [scalar(i, name, *about) for i, (name, about) in enumerate(rows, start=1)]
    outputs = [i for i, (_, about) in enumerate(rows, start=1) if about[0] == "output"]
    unknowns = "".join(f'<Unknown index="{i}"/>' for i in outputs)
    units = "".join(f'<Unit name="{n}"><BaseUnit {b}/></Unit>' for n, b in UNITS.items())
    return (
        '<fmiModelDescription fmiVersion="2.0" modelName="M" guid="g">'
        '<CoSimulation modelIdentifier="M" canGetAndSetFMUstate="true"/>'
        f"<UnitDefinitions>{units}</UnitDefinitions>"
        f"<ModelVariables>{''.join(scalars)}</ModelVariables><ModelStructure>"
        f"<Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns>"
        "</ModelStructure></fmiModelDescription>"
    )


def fmu(path: Path, variables, *, edit=lambda text: text, binary=BINARY) -> Path:
    """Write an FMU with these variables; ``edit`` changes the text of the description."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", edit(xml(variables)))
        archive.writestr(f"binaries/{binary}", b"")
    return path

"""Rules of FMI 2.0 (standard 2.0.4) that a tool relies on and a schema cannot check."""

from __future__ import annotations

import platform
import sys
from collections import Counter
from collections.abc import Iterator
from xml.etree.ElementTree import Element

from rail_cosim.contract import Finding

_DEFAULT_INITIAL = {
    ("output", "constant"): "exact",
    ("local", "constant"): "exact",
    ("local", "fixed"): "calculated",
    ("local", "tunable"): "calculated",
    ("parameter", "fixed"): "exact",
    ("parameter", "tunable"): "exact",
    ("calculatedParameter", "fixed"): "calculated",
    ("calculatedParameter", "tunable"): "calculated",
}
"""Default of ``initial`` by causality and variability (section 2.2.7); else calculated."""
_VARIABILITY = {
    "parameter": ("fixed", "tunable"),
    "calculatedParameter": ("fixed", "tunable"),
    "input": ("discrete", "continuous"),
    "output": ("constant", "discrete", "continuous"),
}
_PLATFORMS = {"linux": "linux", "darwin": "darwin", "win32": "win"}


class _Scalar:
    """A ScalarVariable with the defaults of the standard filled in."""

    def __init__(self, element: Element) -> None:
        self.about = next(child for child in element if child.tag != "Annotations")
        self.name = element.get("name", "")
        self.causality = element.get("causality", "local")
        default = "continuous" if self.about.tag == "Real" else "discrete"
        self.variability = element.get("variability", default)
        declared = _DEFAULT_INITIAL.get((self.causality, self.variability), "calculated")
        self.initial = "" if self.causality == "input" else element.get("initial", declared)
        self.start = self.about.get("start")


def manners_findings(root: Element, members: set[str]) -> list[Finding]:
    """Return what is wrong with a model description.

    Parameters
    ----------
    root
        Root element of ``modelDescription.xml`` (FMI 2.0, co-simulation).
    members
        Names of the FMU's files.
    """
    scalars = [_Scalar(element) for element in root.iterfind("ModelVariables/ScalarVariable")]
    found: list[Finding] = []
    for rule in (_identity, _units):
        found += [Finding(level="fault", subject=s, text=t) for s, t in rule(root)]
    for scalar in scalars:
        found += [Finding(level="fault", subject=scalar.name, text=t) for t in _variable(scalar)]
    for name, count in Counter(s.name for s in scalars).items():
        if count > 1:
            found.append(Finding(level="fault", subject=name, text=f"declared {count} times"))
    found += [Finding(level="fault", subject=s, text=t) for s, t in _structure(root, scalars)]
    return found + _binaries(root, members)


def _identity(root: Element) -> Iterator[tuple[str, str]]:
    for name in ("modelName", "guid"):
        if not root.get(name):
            yield name, "missing or empty"


def _units(root: Element) -> Iterator[tuple[str, str]]:
    defined = {unit.get("name") for unit in root.iterfind("UnitDefinitions/Unit")}
    used: dict[str, str] = {}
    for element in root.iter("Real"):
        if unit := element.get("unit"):
            used.setdefault(unit, unit)
    for unit in used:
        if unit not in defined:
            yield f"unit {unit}", "is used, but not in UnitDefinitions"


def _variable(scalar: _Scalar) -> Iterator[str]:
    allowed = _VARIABILITY.get(scalar.causality)
    if allowed and scalar.variability not in allowed:
        yield f"{scalar.causality} with variability {scalar.variability}; allowed: " + ", ".join(
            allowed
        )
    needs = scalar.causality == "input" or scalar.initial in ("exact", "approx")
    if needs and scalar.start is None:
        yield "has no start value"
    if scalar.initial == "calculated" and scalar.start is not None:
        yield "is calculated, but has a start value"
    yield from _limits(scalar)


def _limits(scalar: _Scalar) -> Iterator[str]:
    if scalar.about.tag not in ("Real", "Integer") or scalar.start is None:
        return
    try:
        start = float(scalar.start)
        low, high = (float(scalar.about.get(k, v)) for k, v in (("min", "-inf"), ("max", "inf")))
    except ValueError:
        yield f"start, min or max is no number: {scalar.start}"
        return
    if not low <= start <= high:
        yield f"starts with {start:g}, outside its limits {low:g} to {high:g}"


def _structure(root: Element, scalars: list[_Scalar]) -> Iterator[tuple[str, str]]:
    def listed(part: str) -> set[int]:
        found = root.iterfind(f"ModelStructure/{part}/Unknown")
        return {int(unknown.get("index", "0")) for unknown in found}

    outputs = {i for i, s in enumerate(scalars, start=1) if s.causality == "output"}
    unknowns = {
        i
        for i, s in enumerate(scalars, start=1)
        if s.causality == "calculatedParameter"
        or (s.causality == "output" and s.initial in ("approx", "calculated"))
    }
    for part, wanted in (("Outputs", outputs), ("InitialUnknowns", unknowns)):
        given = listed(part)
        if missing := sorted(wanted - given):
            names = ", ".join(scalars[i - 1].name for i in missing[:3])
            more = f" and {len(missing) - 3} more" if len(missing) > 3 else ""
            yield f"ModelStructure/{part}", f"does not list {names}{more}"
        for index in sorted(given - wanted):
            name = scalars[index - 1].name if 0 < index <= len(scalars) else f"index {index}"
            # States and derivatives of a continuous model are unknowns too.
            if part == "Outputs" or not 0 < index <= len(scalars):
                yield f"ModelStructure/{part}", f"lists {name}, which does not belong there"


def _binaries(root: Element, members: set[str]) -> list[Finding]:
    interface = root.find("CoSimulation")
    identifier = "" if interface is None else interface.get("modelIdentifier", "")
    bits = "64" if sys.maxsize > 2**32 else "32"
    here = _PLATFORMS.get(sys.platform, sys.platform) + bits
    suffix = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
    if f"binaries/{here}/{identifier}{suffix}" in members:
        return []
    have = sorted({n.split("/")[1] for n in members if n.startswith("binaries/") and n[-1] != "/"})
    text = (
        f"no {identifier}{suffix} for {here} ({platform.machine()}); there are "
        f"{', '.join(have) or 'none'}"
    )
    return [Finding(level="fault", subject="binaries", text=text)]

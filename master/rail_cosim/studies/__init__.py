"""Studies: each makes one table or figure of the verification, with data and plot.

A study is a module with a function ``run(options, reporter) -> StudyResult``; it is loaded
when it is asked for.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from rail_cosim.errors import UnknownNameError
from rail_cosim.slave import Value
from rail_cosim.studies.base import StudyOptions, StudyResult, make_directory

if TYPE_CHECKING:
    from rail_cosim.reporter import Reporter

__all__ = ["ALL", "STUDIES", "StudyOptions", "StudyResult", "run_study", "study"]

ALL = "all"
"""On the command line: every study."""

STUDIES = {
    "critical-speed": "speed above which a lateral offset no longer dies out",
    "contact-geometry": "contact of wheel and rail over the wheelset's lateral displacement",
    "slide": "disturbance of the wheel forces by the slides, over the ways of sliding",
    "convergence": "error over the number of rail and slab modes, with and without residual",
    "table1": "Table 1: moving mass, moving irregularity, sliding window and ring, measured",
    "fig05": "Fig. 5: rail before and after a window shift, triangular solve and least squares",
    "fig06": "Fig. 6: rail joint at the instant of a window shift, sliding window and moving mass",
    "receptance": "receptance of the rail heads from 2 Hz to 2 kHz",
    "p2": "P2 resonance over pad stiffness: the article's formula and coupled eigenfrequencies",
    "fig10": "Fig. 10: shape of the coupled P2 mode",
    "fig11": "axle-box acceleration over speed for several pad stiffnesses",
    "fig13": "wheel lift-off at the resonance; influence of the pad damping",
    "fig14": "influence of the unsprung mass",
    "fig15": "influence of sleeper bay, axle load and primary damping",
    "table3": "resonance speed and frequency over the sleeper bay",
    "fig08": "accelerations of axle box, bogie and car body at 200 km/h",
    "fig09": "spectra of the axle-box acceleration in winter and summer",
    "fig07": "random irregularity: sliding window and moving irregularity",
    "fig16": "deflection of the primary suspension, and its spectrogram while speeding up",
    "fig17": "wheel force and axle-box acceleration over slab joints",
    "fig18": "slab passing over speed and stiffness of the CAM layer",
    "fig12": "axle-box acceleration at 200 km/h with winter pads",
}
"""What there is, by name; the module of ``some-name`` is ``some_name``."""


def run_study(name: str, options: StudyOptions, reporter: Reporter) -> StudyResult:
    """Do the study of this name.

    Raises
    ------
    UnknownNameError
        If there is none of this name.
    """
    if name not in STUDIES:
        raise UnknownNameError("study", name, STUDIES, "study", wanted=name, listed=True)
    make_directory(options.out)
    module = import_module(f"{__name__}.{name.replace('-', '_')}")
    return module.run(options, reporter)


def study(
    name: str,
    *,
    out: str | Path = ".",
    quick: bool = False,
    settings: Mapping[str, Value] | None = None,
    reporter: Reporter | None = None,
) -> StudyResult:
    """Do a study; mirrors ``rail-cosim study``.

    Parameters
    ----------
    name
        One of :data:`STUDIES`.
    out, quick
        As in :class:`StudyOptions`.
    settings
        Parameter values by full name.
    reporter
        Told of stages, progress and warnings.

    Raises
    ------
    RailCosimError
        If it cannot be done.
    """
    from rail_cosim.reporter import Quiet

    options = StudyOptions(
        out=Path(out),
        quick=quick,
        settings=[f"{key}={value}" for key, value in (settings or {}).items()],
        command=shlex.join(sys.argv),
    )
    return run_study(name, options, reporter or Quiet())

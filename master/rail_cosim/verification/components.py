"""Values of the components alone, computed by their own packages in processes of their own."""

from __future__ import annotations

import json
import subprocess
import sys

from rail_cosim.builder import child_environment
from rail_cosim.errors import RailCosimError
from rail_cosim.verification.rows import Values, from_json

MODULES = {
    "track": "slab_track.verification",
    "vehicle": "rail_vehicle.verification",
}


def component_values(name: str) -> Values:
    """Return the values of ``track`` or ``vehicle``.

    Raises
    ------
    RailCosimError
        With what the process says, if it fails.
    """
    module = MODULES[name]
    done = subprocess.run(
        [sys.executable, "-m", module],
        capture_output=True,
        text=True,
        check=False,
        env=child_environment(),
    )
    if done.returncode != 0:
        said = done.stderr.strip().splitlines()
        reason = said[-1] if said else f"exit status {done.returncode}"
        raise RailCosimError(f"python -m {module}: {reason}")
    return from_json(json.loads(done.stdout))

"""Compiles the cores of the FMUs when a wheel or an editable install is made."""

import os
import subprocess
import sys
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SOURCES = ("fmus/common", "fmus/vehicle", "fmus/track", "master")
PACKAGES = ("rail_vehicle", "slab_track", "rail_cosim")


class CompileCores(BuildHookInterface):
    """Compile where the library is not fresh; the wheel is then one for a platform."""

    def dependencies(self) -> list[str]:
        """Return a C compiler's package where the system has none."""
        sys.path.insert(0, str(Path(self.root, SOURCES[0])))
        from rail_native.compiler import has_linker

        return [] if has_linker() else ["ziglang"]

    def initialize(self, version: str, build_data: dict) -> None:
        """Run the compiler before files are collected."""
        # The isolated environment of a build is in this process's path only.
        paths = [*(str(Path(self.root, folder)) for folder in SOURCES), *filter(None, sys.path)]
        subprocess.run(
            [sys.executable, "-m", "rail_native", *PACKAGES],
            env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
            check=True,
        )
        build_data["pure_python"] = False
        build_data["infer_tag"] = True
        build_data["artifacts"] += ["fmus/*/*/native/*", "master/*/native/*"]

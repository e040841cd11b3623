"""Compiles the cores of the FMUs when a wheel or an editable install is made."""

import sys
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SOURCES = ("fmus/common", "fmus/vehicle", "fmus/track", "master")
PACKAGES = ("rail_vehicle", "slab_track", "rail_cosim")


class CompileCores(BuildHookInterface):
    """Compile where the library is not fresh; the wheel is then one for a platform."""

    def dependencies(self) -> list[str]:
        """Return a C compiler's package where the system has none."""
        self._find_sources()
        from rail_native.compiler import has_linker

        return [] if has_linker() else ["ziglang"]

    def initialize(self, version: str, build_data: dict) -> None:
        """Run the compiler before files are collected."""
        self._find_sources()
        from rail_native.__main__ import make

        for package in PACKAGES:
            make(package)
        build_data["pure_python"] = False
        build_data["infer_tag"] = True
        build_data["artifacts"] += ["fmus/*/*/native/*", "master/*/native/*"]

    def _find_sources(self) -> None:
        for folder in SOURCES:
            if (path := str(Path(self.root, folder))) not in sys.path:
                sys.path.insert(0, path)

"""Entry script of MassSpring.fmu."""

from __future__ import annotations

from mass_spring.slave import MassSpringSlave


class MassSpring(MassSpringSlave):
    """The slave of the FMU."""

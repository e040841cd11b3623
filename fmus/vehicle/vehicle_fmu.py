"""Entry script of HighSpeedVehicle.fmu."""

from __future__ import annotations

from rail_vehicle.slave import VehicleSlave


class HighSpeedVehicle(VehicleSlave):
    """The slave of the FMU."""

    def __init__(self, **kwargs):  # pythonfmu needs a method of the class itself
        super().__init__(**kwargs)

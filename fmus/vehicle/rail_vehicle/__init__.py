"""High-speed rail vehicle with 50 degrees of freedom, driven by contact forces.

``VehicleModel(parameters)`` gives the static equilibrium, a pure step and the
outputs; parameters are frozen dataclasses with named presets. The package
knows nothing of FMI except in ``rail_vehicle.slave``.
"""

from rail_vehicle.coupling import ForceHistory
from rail_vehicle.errors import StepError
from rail_vehicle.linear_system import LinearSystem
from rail_vehicle.model import VehicleModel, VehicleOutputs, VehicleState
from rail_vehicle.outputs import Output
from rail_vehicle.parameters import VehicleParameters
from rail_vehicle.presets import MANCHESTER_1, PAPER, PRESETS, SOFT_PRIMARY

__all__ = [
    "MANCHESTER_1",
    "PAPER",
    "PRESETS",
    "SOFT_PRIMARY",
    "ForceHistory",
    "LinearSystem",
    "Output",
    "StepError",
    "VehicleModel",
    "VehicleOutputs",
    "VehicleParameters",
    "VehicleState",
]

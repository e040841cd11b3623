"""What most tests need compiled, called once before the workers of a session start."""

import numpy as np


def product() -> None:
    """Build both FMUs and run them past a slide of the window, in the session's cache."""
    import rail_cosim

    rail_cosim.run(distance=6.0, irregularity="german_low")


def references() -> None:
    """Compile the vehicle, which the other process comes to last, and the finite elements."""
    from rail_vehicle import VehicleModel, VehicleParameters
    from reference_fe import ReferenceTrack, ReferenceVehicle, SingleWheel, simulate

    vehicle = VehicleModel(VehicleParameters())
    forces = vehicle.static_forces
    vehicle.step(vehicle.initial_state(np.zeros(4)), forces, forces, 1e-4)
    for moving in (SingleWheel(), ReferenceVehicle()):
        simulate(ReferenceTrack(), moving, 80.0, 1.0, step=1e-4)

"""What most tests need compiled, called once before the workers of a session start."""


def product() -> None:
    """Build both FMUs and run them, in the session's cache."""
    import rail_cosim

    rail_cosim.run(distance=1.0)


def references() -> None:
    """Compile the finite elements."""
    from reference_fe import ReferenceTrack, ReferenceVehicle, SingleWheel, simulate

    for moving in (SingleWheel(), ReferenceVehicle()):
        simulate(ReferenceTrack(), moving, 80.0, 1.0, step=1e-4)

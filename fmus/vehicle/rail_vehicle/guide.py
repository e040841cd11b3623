"""What a user of the vehicle FMU has to know; it goes into the FMU's documentation."""

from collections.abc import Mapping

from rail_quantities import terminals

GUIDE: Mapping[str, str] = {
    "Frame and signs": terminals.FRAME,
    "Start": (
        "Start at rest: wheelset[i].initial_vertical_displacement is the height that the track "
        "gives as wheelset[i].static_vertical_displacement in initialization mode, and the "
        "contact forces are set before the mode is left. The set start of an SSP made with "
        "rail-cosim build --at-rest has these values, for tools that connect inputs only. "
        "Without them the run starts with a transient of some kN, and is right after it."
    ),
    "Inputs that are not connected": (
        "Some tools set them to 0. speed_setpoint = 0 brakes the vehicle to a stand: give it the "
        "value of speed (its start value stands for that). A set point more than 1 m/s from speed "
        "at the start is told as a warning. Some tools set connected inputs to 0 in the first "
        "step, too: coupling.keep_first_inputs = true makes it with the inputs that "
        "initialization ended with."
    ),
    "Communication step": (
        "0.1 ms; 1 ms is too much, and the FMU warns of steps that are too coarse or ends the run "
        "where the coupling is unstable. coupling.input_time is step_start where all FMUs are "
        "stepped from the same instant (Jacobi), step_end where the vehicle is stepped after the "
        "track, with its new forces (Gauss-Seidel). Between steps no output depends on an input."
    ),
}
"""Text by heading."""

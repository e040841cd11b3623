"""What a user of the track FMU has to know; it goes into the FMU's documentation."""

from collections.abc import Mapping

from rail_quantities import terminals

GUIDE: Mapping[str, str] = {
    "Frame and signs": terminals.FRAME,
    "Start": (
        "Start at rest: in initialization mode give it the vehicle's static_wheel_load and wheel "
        "radius (static_wheel_load, contact.wheel_radius) and the motions of the wheelsets, then "
        "give the vehicle wheelset[i].static_vertical_displacement and the contact forces. The "
        "set start of an SSP made with rail-cosim build --at-rest has these values, for tools "
        "that connect inputs only."
    ),
    "Inputs that are not connected": (
        "Some tools set them to 0. The forces rail_head[i].* are 0 then, as at the start, and "
        "count with interface = applied_force only. wheelset[i].longitudinal_position must follow "
        "the vehicle in each step. Some tools set connected inputs to 0 in the first step, too: "
        "coupling.keep_first_inputs = true makes it with the inputs that initialization ended "
        "with."
    ),
    "Communication step": (
        "0.1 ms. coupling.input_time is step_start: the motions stand for the beginning of the "
        "step, and are extrapolated over it. Between steps no output depends on an input."
    ),
}
"""Text by heading."""

"""Constants of the kernels, made from the parameters."""

from rail_vehicle.kernels import Constants, Laws
from rail_vehicle.limits import motion_limits
from rail_vehicle.linear_system import FirstOrderSystem
from rail_vehicle.outputs import OutputMap
from rail_vehicle.parameters import VehicleParameters


def step_constants(
    parameters: VehicleParameters, system: FirstOrderSystem, outputs: OutputMap
) -> Constants:
    """Return what a step takes besides its operators."""
    return Constants(
        laws=law_constants(parameters),
        spin_inertia=system.spin_inertia,
        rolling_spin=-parameters.speed / parameters.wheelset.radius,
        static_force=-2.0 * parameters.static_wheel_load,
        acceleration_limit=parameters.speed_constraint.acceleration_limit,
        limits=motion_limits(parameters),
        output_offsets=outputs.offsets,
        output_values=outputs.values,
        output_columns=outputs.columns,
        output_rows=outputs.row_starts,
    )


def law_constants(parameters: VehicleParameters) -> Laws:
    """Constants of the force laws."""
    yaw, lateral = parameters.yaw_damper, parameters.lateral_damper
    stop = parameters.lateral_bump_stop
    return Laws(
        yaw_damping=yaw.damping,
        yaw_blow_off_force=yaw.blow_off_force,
        yaw_blow_off_damping=yaw.blow_off_damping,
        yaw_series_stiffness=yaw.series_stiffness,
        lateral_damping=lateral.damping,
        lateral_blow_off_force=lateral.blow_off_force,
        lateral_blow_off_damping=lateral.blow_off_damping,
        stop_clearance=stop.clearance,
        stop_stiffness=stop.stiffness,
        stop_cubic_stiffness=stop.cubic_stiffness,
    )

"""Named vehicles.

``PAPER`` is the vehicle of the article. ``SOFT_PRIMARY`` is the same with a
tenth of its primary stiffness, which puts the bogie's bounce at the usual
6.5 Hz. ``MANCHESTER_1`` is vehicle 1 of the Manchester benchmarks (S. Iwnicki
(ed.), The Manchester Benchmarks for Rail Vehicle Simulation, 1998) on this
model's arrangement: its two secondary lateral dampers of 32 kN s/m are one
element of 64 kN s/m that does not blow off within its stroke, series
stiffnesses and the traction rod are left out, its stop is a fitted cubic, and
its axle boxes have this project's pitch inertia, as it gives none.
"""

from rail_vehicle.parameters import (
    AntiRollBar,
    AxleBox,
    Bogie,
    CarBody,
    LateralBumpStop,
    LateralDamper,
    PrimarySuspension,
    SecondarySuspension,
    VehicleParameters,
    Wheelset,
    YawDamper,
)

PAPER = VehicleParameters()

SOFT_PRIMARY = PAPER.replace(
    primary_suspension=PAPER.primary_suspension.replace(vertical_stiffness=0.9e6)
)

MANCHESTER_1 = VehicleParameters(
    car_body=CarBody(
        mass=32000.0,
        roll_inertia=56.8e3,
        pitch_inertia=1.97e6,
        yaw_inertia=1.97e6,
        centre_of_gravity_height=1.8,
        half_bogie_spacing=9.5,
    ),
    bogie=Bogie(
        mass=2615.0,
        roll_inertia=1722.0,
        pitch_inertia=1476.0,
        yaw_inertia=3067.0,
        centre_of_gravity_height=0.6,
        half_wheelbase=1.28,
    ),
    wheelset=Wheelset(
        mass=1813.0, roll_inertia=1120.0, pitch_inertia=112.0, yaw_inertia=1120.0, radius=0.46
    ),
    axle_box=AxleBox(),
    primary_suspension=PrimarySuspension(
        vertical_stiffness=1.2e6,
        vertical_damping=4.0e3,
        longitudinal_stiffness=31.391e6,
        longitudinal_damping=15.0e3,
        lateral_stiffness=3.884e6,
        lateral_damping=2.0e3,
        half_span=1.0,
        guide_offset=0.0,
    ),
    secondary_suspension=SecondarySuspension(
        vertical_stiffness=0.43e6,
        vertical_damping=20.0e3,
        longitudinal_stiffness=0.16e6,
        longitudinal_damping=0.0,
        lateral_stiffness=0.16e6,
        lateral_damping=0.0,
        half_span=1.0,
        height=0.8275,
    ),
    lateral_damper=LateralDamper(
        damping=64.0e3, blow_off_force=64.0e3, blow_off_damping=64.0e3, height=0.70
    ),
    yaw_damper=YawDamper(damping=0.0),
    anti_roll_bar=AntiRollBar(roll_stiffness=0.94e6),
    lateral_bump_stop=LateralBumpStop(
        clearance=0.025, stiffness=1.2e5, cubic_stiffness=5.5e8, height=0.65
    ),
)

PRESETS: dict[str, VehicleParameters] = {
    "paper": PAPER,
    "soft_primary": SOFT_PRIMARY,
    "manchester1": MANCHESTER_1,
}
"""Every named vehicle, by the name it has on the command line."""

"""Parameters of the vehicle: values, units, limits, meaning and source of each.

Default values are Table 2 of the article (``PAPER``); what the article does
not print comes from published data of comparable vehicles, named beside the
value, or is an engineering assumption and says so. Heights are above the top
of rail; lengths along x and y are measured from the centre of the body named.

Sources
-------
CRH6
    Parameters of a CRH6 train, Advances in Civil Engineering 2020, 4515319,
    Table 1.
Hunting
    Parameters of a 17-DOF high-speed vehicle, Mathematical Problems in
    Engineering 2019, 7163732, Table 2.
Axle box
    Shock and Vibration 2021, 5530474, Table 1.
CRH380A
    Published characteristic of a CRH380A secondary lateral damper and of a
    progressive lateral stop.
"""

import dataclasses
from typing import ClassVar

from rail_quantities import ParameterError, ParameterSet, quantity

_TABLE_2 = "Table 2 of the article"
_ASSUMED = "engineering assumption"


LARGEST_DISPLACEMENT = 5.0
"""How far a body may be from where it rests, m: all gauges, clearances and heights of flanges are
less, and what is farther is no longer a vehicle on a track."""

_LARGEST_LENGTH = 10.0
"""No part of a vehicle is farther from the middle of its body, m."""


def _field(default: float, unit: str, description: str, **more: object) -> float:
    """Declare a quantity that must be positive, and no longer than a part of a vehicle can be.

    Other limits replace these.
    """
    if not {"above", "at_least"} & more.keys():
        more["above"] = 0.0
    if unit == "m":
        more.setdefault("at_most", _LARGEST_LENGTH)
    return quantity(default, unit, description, **more)


def _check_blow_off(group: ParameterSet, damping: float, after: float) -> None:
    if after > damping:
        raise ParameterError(
            f"{group.GROUP}.blow_off_damping",
            after,
            f"must be at most {group.GROUP}.damping = {damping:g} N.s/m",
            "a damper gets softer when it blows off",
        )


@dataclasses.dataclass(frozen=True, kw_only=True)
class CarBody(ParameterSet):
    """The car body, a rigid body on two bogies."""

    GROUP: ClassVar[str] = "car_body"

    mass: float = _field(44039.0, "kg", "Mass", symbol="M_c", source=_TABLE_2)
    roll_inertia: float = _field(
        1.27e5, "kg.m2", "Roll inertia", symbol="I_cx", source="CRH6, scaled by mass"
    )
    pitch_inertia: float = _field(
        1.69e6, "kg.m2", "Pitch inertia", symbol="I_cy", source="CRH6, scaled by mass"
    )
    yaw_inertia: float = _field(
        1.66e6, "kg.m2", "Yaw inertia", symbol="I_cz", source="CRH6, scaled by mass"
    )
    centre_of_gravity_height: float = _field(
        1.71, "m", "Height of the centre of gravity above the rail", symbol="h_c", source="CRH6"
    )
    floor_height: float = _field(
        1.25,
        "m",
        "Height of the floor above the rail, for the outputs there",
        source=f"{_ASSUMED}: level with platforms of 1.25 m",
    )
    half_bogie_spacing: float = _field(
        8.9,
        "m",
        "Half the distance between the bogie centres",
        at_most=50.0,
        symbol="L_c",
        source=_TABLE_2,
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Bogie(ParameterSet):
    """One bogie frame."""

    GROUP: ClassVar[str] = "bogie"

    mass: float = _field(2439.0, "kg", "Mass of one frame", symbol="M_t", source=_TABLE_2)
    roll_inertia: float = _field(
        1.98e3, "kg.m2", "Roll inertia", symbol="I_tx", source="CRH6, scaled by mass"
    )
    pitch_inertia: float = _field(1846.0, "kg.m2", "Pitch inertia", symbol="I_ty", source=_TABLE_2)
    yaw_inertia: float = _field(
        2.44e3, "kg.m2", "Yaw inertia", symbol="I_tz", source="CRH6, scaled by mass"
    )
    centre_of_gravity_height: float = _field(
        0.50, "m", "Height of the centre of gravity above the rail", symbol="h_t", source="CRH6"
    )
    half_wheelbase: float = _field(
        1.25, "m", "Half the distance between the axles", symbol="L_t", source=_TABLE_2
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Wheelset(ParameterSet):
    """One wheelset with its two axle boxes, which move with it except in pitch."""

    GROUP: ClassVar[str] = "wheelset"

    mass: float = _field(
        1881.0, "kg", "Mass of one wheelset with its two axle boxes", symbol="M_ws", source=_TABLE_2
    )
    roll_inertia: float = _field(
        923.0, "kg.m2", "Roll inertia, axle boxes included", symbol="I_wx", source="CRH6"
    )
    pitch_inertia: float = _field(
        146.0, "kg.m2", "Inertia about the axle of all that spins", symbol="I_wy", source="CRH6"
    )
    yaw_inertia: float = _field(
        923.0, "kg.m2", "Yaw inertia, axle boxes included", symbol="I_wz", source="CRH6"
    )
    radius: float = _field(0.46, "m", "Wheel radius", symbol="R_w", source=_TABLE_2)


@dataclasses.dataclass(frozen=True, kw_only=True)
class AxleBox(ParameterSet):
    """One axle box. It pitches about the axle on frictionless bearings."""

    GROUP: ClassVar[str] = "axle_box"

    mass: float = _field(
        84.0,
        "kg",
        "Mass, contained in the wheelset's; it acts on the load of the journal only",
        at_least=0.0,
        symbol="M_b",
        source="Axle box",
    )
    pitch_inertia: float = _field(
        3.9, "kg.m2", "Pitch inertia about the axle", symbol="I_by", source="Axle box"
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class PrimarySuspension(ParameterSet):
    """The primary suspension of one axle box: two coil springs and a guide."""

    GROUP: ClassVar[str] = "primary_suspension"

    vertical_stiffness: float = _field(
        9.0e6, "N/m", "Vertical stiffness per axle box", symbol="K_pz", source=_TABLE_2
    )
    vertical_damping: float = _field(
        10.5e3, "N.s/m", "Vertical damping per box", at_least=0.0, symbol="C_pz", source=_TABLE_2
    )
    longitudinal_stiffness: float = _field(
        13.7e6, "N/m", "Longitudinal stiffness of the guide", symbol="K_px", source="CRH6"
    )
    longitudinal_damping: float = _field(
        10.0e3,
        "N.s/m",
        "Longitudinal damping of the guide",
        at_least=0.0,
        symbol="C_px",
        source=f"{_ASSUMED}: rubber with a loss factor of 0.1 near 20 Hz",
    )
    lateral_stiffness: float = _field(
        5.5e6, "N/m", "Lateral stiffness of the guide", symbol="K_py", source="CRH6"
    )
    lateral_damping: float = _field(
        10.0e3, "N.s/m", "Lateral damping of guide", at_least=0.0, symbol="C_py", source="Hunting"
    )
    half_span: float = _field(
        1.0, "m", "Lateral distance of the axle box from the centre", symbol="b_p", source="Hunting"
    )
    spring_half_spacing: float = _field(
        0.20,
        "m",
        "Distance of either coil spring from the axle, fore and aft",
        symbol="a_p",
        source=f"{_ASSUMED}: springs clear of the bearing housing",
    )
    guide_offset: float = _field(
        0.48,
        "m",
        "Distance of the guide's bush from the axle, towards the bogie's centre",
        at_least=0.0,
        symbol="a_g",
        source="CRH6",
    )
    guide_height: float = _field(
        0.46, "m", "Height of the guide's bush above the rail", symbol="h_g", source="CRH6"
    )
    guide_vertical_stiffness: float = _field(
        0.0,
        "N/m",
        "Vertical stiffness of the guide's bush; 0 for a link, large for a swing arm",
        at_least=0.0,
        symbol="K_gz",
        source="so that Table 2 gives all of the vertical path",
    )
    guide_vertical_damping: float = _field(
        0.0,
        "N.s/m",
        "Vertical damping of the guide's bush",
        at_least=0.0,
        symbol="C_gz",
        source="so that Table 2 gives all of the vertical path",
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class SecondarySuspension(ParameterSet):
    """The secondary suspension of one side of a bogie."""

    GROUP: ClassVar[str] = "secondary_suspension"

    vertical_stiffness: float = _field(
        0.24e6, "N/m", "Vertical stiffness per bogie side", symbol="K_sz", source=_TABLE_2
    )
    vertical_damping: float = _field(
        25.0e3, "N.s/m", "Vertical damping per side", at_least=0.0, symbol="C_sz", source=_TABLE_2
    )
    longitudinal_stiffness: float = _field(
        0.18e6, "N/m", "Longitudinal stiffness per bogie side", symbol="K_sx", source="CRH6"
    )
    longitudinal_damping: float = _field(
        3.0e3,
        "N.s/m",
        "Longitudinal damping per bogie side, yaw damper apart",
        at_least=0.0,
        symbol="C_sx",
        source=f"{_ASSUMED}: rubber with a loss factor of 0.1 at 1 Hz",
    )
    lateral_stiffness: float = _field(
        0.18e6, "N/m", "Lateral stiffness per bogie side", symbol="K_sy", source="CRH6"
    )
    lateral_damping: float = _field(
        3.0e3,
        "N.s/m",
        "Lateral damping per bogie side, lateral damper apart",
        at_least=0.0,
        symbol="C_sy",
        source=f"{_ASSUMED}: rubber with a loss factor of 0.1 at 1 Hz",
    )
    half_span: float = _field(
        1.23, "m", "Lateral distance of the spring from the centre", symbol="b_s", source="Hunting"
    )
    height: float = _field(
        0.76, "m", "Height of the spring's middle above the rail", symbol="h_s", source="CRH6"
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class LateralDamper(ParameterSet):
    """The secondary lateral dampers of one bogie, as one element at its centre."""

    GROUP: ClassVar[str] = "lateral_damper"

    damping: float = _field(
        30.0e3,
        "N.s/m",
        "Damping below blow-off; 0 for none",
        at_least=0.0,
        symbol="C_ld",
        source="Hunting",
    )
    blow_off_force: float = _field(
        4.5e3,
        "N",
        "Force above which the damper blows off",
        symbol="F_ld",
        source="at 0.15 m/s, as CRH380A",
    )
    blow_off_damping: float = _field(
        3.1e3,
        "N.s/m",
        "Damping above blow-off",
        at_least=0.0,
        symbol="C_lb",
        source="ratio to the first stage as CRH380A",
    )
    height: float = _field(
        0.74, "m", "Height above the rail", symbol="h_ld", source="Hunting: 0.97 m below the car's"
    )

    def check(self) -> None:
        """Refuse a damper that stiffens when it blows off."""
        if self.damping > 0.0:
            _check_blow_off(self, self.damping, self.blow_off_damping)


@dataclasses.dataclass(frozen=True, kw_only=True)
class YawDamper(ParameterSet):
    """One yaw damper (one on each bogie side): a blow-off dashpot behind a spring."""

    GROUP: ClassVar[str] = "yaw_damper"

    damping: float = _field(
        300.0e3,
        "N.s/m",
        "Damping below blow-off; 0 takes the damper away",
        at_least=0.0,
        symbol="C_yd",
        source="Hunting",
    )
    blow_off_force: float = _field(
        9.0e3,
        "N",
        "Force above which the damper blows off",
        symbol="F_yd",
        source="at 0.03 m/s, as dampers of vehicles for 300 km/h do at 8 to 12 kN; with the 3 kN "
        "of Hunting a lateral kick of 10 mm ends in hunting between the flanges at 300 km/h",
    )
    blow_off_damping: float = _field(
        20.0e3, "N.s/m", "Damping above blow-off", symbol="C_yb", source="Hunting"
    )
    series_stiffness: float = _field(
        10.0e6, "N/m", "Stiffness in series, bushes and oil", symbol="K_yd", source="Hunting"
    )
    half_span: float = _field(
        1.35, "m", "Lateral distance of the damper from centre", symbol="b_yd", source="Hunting"
    )
    height: float = _field(
        0.50,
        "m",
        "Height above the rail",
        symbol="h_yd",
        source=f"{_ASSUMED}: level with the frame's centre of gravity",
    )

    def check(self) -> None:
        """Refuse a damper that stiffens when it blows off."""
        if self.damping > 0.0:
            _check_blow_off(self, self.damping, self.blow_off_damping)


@dataclasses.dataclass(frozen=True, kw_only=True)
class AntiRollBar(ParameterSet):
    """The anti-roll bar of one bogie."""

    GROUP: ClassVar[str] = "anti_roll_bar"

    roll_stiffness: float = _field(
        0.94e6,
        "N.m/rad",
        "Roll stiffness between car body and one frame",
        at_least=0.0,
        symbol="K_ar",
        source="Manchester benchmark vehicle 1",
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class LateralBumpStop(ParameterSet):
    """The lateral stop of one bogie, the same on both sides."""

    GROUP: ClassVar[str] = "lateral_bump_stop"

    clearance: float = _field(
        0.030, "m", "Free play to either side", at_least=0.0, symbol="d_bs", source=_ASSUMED
    )
    stiffness: float = _field(
        1.2e5,
        "N/m",
        "Stiffness at first touch",
        at_least=0.0,
        symbol="K_bs",
        source="fitted to CRH380A's stop",
    )
    cubic_stiffness: float = _field(
        1.3e9,
        "N/m3",
        "Factor of the third power of the compression",
        at_least=0.0,
        symbol="K_b3",
        source="fitted to CRH380A's stop",
    )
    height: float = _field(
        0.74, "m", "Height above the rail", symbol="h_bs", source=f"{_ASSUMED}: at the dampers"
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class SpeedConstraint(ParameterSet):
    """The ideal constraint that holds the car body to the speed setpoint."""

    GROUP: ClassVar[str] = "speed_constraint"

    acceleration_limit: float = _field(
        10.0,
        "m/s2",
        "Largest acceleration with which the speed follows its setpoint",
        source=f"{_ASSUMED}: beyond what adhesion allows, so that a jump of the setpoint is a ramp",
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class VehicleParameters(ParameterSet):
    """All parameters of the vehicle, defaults as in the article (``PAPER``)."""

    speed: float = _field(300.0 / 3.6, "m/s", "Running speed", at_least=0.0, symbol="V")
    initial_position: float = quantity(
        0.0, "m", "Longitudinal position of the leading wheelset at the start", symbol="x_0"
    )
    initial_lateral_displacement: float = quantity(
        0.0,
        "m",
        "Lateral displacement of the whole vehicle at the start, without deforming it",
        at_least=-LARGEST_DISPLACEMENT,
        at_most=LARGEST_DISPLACEMENT,
        symbol="y_0",
        nominal=5e-3,
    )
    gravity: float = _field(9.81, "m/s2", "Acceleration of free fall", at_least=0.0, symbol="g")
    car_body: CarBody = CarBody()
    bogie: Bogie = Bogie()
    wheelset: Wheelset = Wheelset()
    axle_box: AxleBox = AxleBox()
    primary_suspension: PrimarySuspension = PrimarySuspension()
    secondary_suspension: SecondarySuspension = SecondarySuspension()
    lateral_damper: LateralDamper = LateralDamper()
    yaw_damper: YawDamper = YawDamper()
    anti_roll_bar: AntiRollBar = AntiRollBar()
    lateral_bump_stop: LateralBumpStop = LateralBumpStop()
    speed_constraint: SpeedConstraint = SpeedConstraint()

    @property
    def total_mass(self) -> float:
        """Mass of the whole vehicle in kg."""
        return self.car_body.mass + 2.0 * self.bogie.mass + 4.0 * self.wheelset.mass

    @property
    def static_wheel_load(self) -> float:
        """Load of one wheel at rest in N: an eighth of the vehicle's weight."""
        return self.total_mass * self.gravity / 8.0

    def check(self) -> None:
        """Refuse bogies or axles that would stand in each other's place."""
        if self.bogie.half_wheelbase >= self.car_body.half_bogie_spacing:
            raise ParameterError(
                "bogie.half_wheelbase",
                self.bogie.half_wheelbase,
                f"must be less than car_body.half_bogie_spacing = "
                f"{self.car_body.half_bogie_spacing:g} m",
                "the bogies would overlap",
            )
        if 2.0 * self.axle_box.mass >= self.wheelset.mass:
            raise ParameterError(
                "axle_box.mass",
                self.axle_box.mass,
                f"two of them must weigh less than wheelset.mass = {self.wheelset.mass:g} kg",
                "the wheelset's mass contains its axle boxes",
            )

"""Parameters of the reference model, SI units; defaults are Table 2 of the article, HD line."""

from dataclasses import dataclass

import numpy as np

GRAVITY = 9.81
"""Acceleration of gravity in m/s2."""


@dataclass(frozen=True, kw_only=True)
class ReferenceTrack:
    """Straight slab track, vertical, alike on both sides of its centre line.

    Fasteners lie at ``(i - 1/2) * fastener_spacing``; slabs are centred in each pitch of
    ``fastener_count_per_slab * fastener_spacing``. ``slab_support_*`` are per fastener bay, both
    rails together: the foundation has ``slab_support_stiffness / (spacing * width)`` per m2.
    ``slab_length`` = 0 means the pitch less ``slab_gap``.

    Mesh: ``rail_elements_per_bay`` (even, so that every fastener is a node),
    ``slab_elements_per_bay`` along the slab and twice ``slab_elements_across`` over its width;
    ``slab_mode_count`` free plate modes are kept per symmetry, to which the static shapes of the
    rail seats are always added. Wheels passing the rail's elements make a ripple of some 0.3 % at
    ``speed * rail_elements_per_bay / fastener_spacing``: keep it above the band of interest.
    """

    rail_youngs_modulus: float = 2.059e11
    rail_shear_modulus: float = 7.9e10
    rail_density: float = 7860.0
    rail_area: float = 7.745e-3
    rail_second_moment: float = 3.217e-5
    rail_shear_coefficient: float = 0.5329
    rail_distance: float = 1.493
    fastener_spacing: float = 0.629
    fastener_count_per_slab: int = 8
    pad_stiffness: float = 40e6
    pad_damping: float = 52e3
    slab_length: float = 0.0
    slab_gap: float = 0.070
    slab_width: float = 2.5
    slab_thickness: float = 0.17
    slab_density: float = 2800.0
    slab_youngs_modulus: float = 3.6e10
    slab_poisson_ratio: float = 0.2
    slab_damping_ratio: float = 0.0
    slab_support_stiffness: float = 5000e6
    slab_support_damping: float = 300e3
    rail_elements_per_bay: int = 8
    slab_elements_per_bay: int = 3
    slab_elements_across: int = 8
    slab_mode_count: int = 60

    def __post_init__(self) -> None:
        if self.rail_elements_per_bay < 2 or self.rail_elements_per_bay % 2:
            raise ValueError(
                f"rail_elements_per_bay = {self.rail_elements_per_bay}: take an even number, "
                "so that fasteners (at mid-bay) are nodes"
            )
        seat_reach = (self.fastener_count_per_slab - 1) * self.fastener_spacing
        if not seat_reach < self.actual_slab_length <= self.pitch:
            raise ValueError(
                f"slab_length = {self.actual_slab_length} m: it must hold its fasteners "
                f"({seat_reach} m) and fit its pitch ({self.pitch} m)"
            )

    @property
    def pitch(self) -> float:
        """Distance from slab to slab in m."""
        return self.fastener_count_per_slab * self.fastener_spacing

    @property
    def actual_slab_length(self) -> float:
        """Length of a slab in m."""
        return self.slab_length or self.pitch - self.slab_gap

    @property
    def slab_mass_per_area(self) -> float:
        """Mass of a slab in kg/m2."""
        return self.slab_density * self.slab_thickness

    @property
    def foundation_stiffness(self) -> float:
        """CAM stiffness in N/m3."""
        return self.slab_support_stiffness / (self.fastener_spacing * self.slab_width)

    @property
    def foundation_damping(self) -> float:
        """CAM damping in N s/m3."""
        return self.slab_support_damping / (self.fastener_spacing * self.slab_width)


@dataclass(frozen=True, kw_only=True)
class SingleWheel:
    """One wheel (half a wheelset) on each rail, under a constant force.

    ``static_load`` is the total per wheel in N, left and right. With a ``sprung_mass`` the wheel
    carries it on a spring and a damper (quarter car), within the same total.
    """

    mass: float = 940.5
    static_load: tuple[float, float] = (69.21e3, 69.21e3)
    sprung_mass: float = 0.0
    suspension_stiffness: float = 0.0
    suspension_damping: float = 0.0
    hertz_constant: float = 4.221e-8

    @property
    def symmetric(self) -> bool:
        """Whether both rails move alike."""
        return self.static_load[0] == self.static_load[1]

    @property
    def axle_positions(self) -> np.ndarray:
        """Wheelsets behind the leading one, in m (shape: wheelset)."""
        return np.zeros(1)


@dataclass(frozen=True, kw_only=True)
class ReferenceVehicle:
    """Car body, two bogies and four wheelsets: bounce, pitch, and roll if loads are unequal.

    Primary values are per axle box (two per wheelset), secondary ones per bogie side.
    ``load_offset`` is the lateral place of the car body's weight in m, right positive.
    """

    car_body_mass: float = 44039.0
    car_body_roll_inertia: float = 1.27e5
    car_body_pitch_inertia: float = 1.69e6
    bogie_mass: float = 2439.0
    bogie_roll_inertia: float = 1.98e3
    bogie_pitch_inertia: float = 1846.0
    wheelset_mass: float = 1881.0
    wheelset_roll_inertia: float = 923.0
    primary_stiffness: float = 9e6
    primary_damping: float = 10.5e3
    primary_half_span: float = 1.0
    secondary_stiffness: float = 0.24e6
    secondary_damping: float = 25e3
    secondary_half_span: float = 1.23
    anti_roll_stiffness: float = 0.94e6
    half_bogie_distance: float = 8.9
    half_wheelbase: float = 1.25
    load_offset: float = 0.0
    hertz_constant: float = 4.221e-8

    @property
    def symmetric(self) -> bool:
        """Whether both rails move alike."""
        return self.load_offset == 0.0

    @property
    def axle_positions(self) -> np.ndarray:
        """Wheelsets behind the leading one, in m (shape: wheelset)."""
        outer, inner = 2 * self.half_bogie_distance, 2 * self.half_wheelbase
        return -np.array([0.0, inner, outer, outer + inner])

    @property
    def total_mass(self) -> float:
        """Mass in kg."""
        return self.car_body_mass + 2 * self.bogie_mass + 4 * self.wheelset_mass

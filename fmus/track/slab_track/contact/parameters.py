"""Parameters of the wheel/rail contact: the group ``contact``."""

import dataclasses

from rail_quantities import ParameterSet, quantity

from slab_track.contact.geometry import RailPlacement


@dataclasses.dataclass(frozen=True, kw_only=True)
class Steel:
    """Elastic constants of wheel and rail.

    Attributes
    ----------
    youngs_modulus
        Pa.
    poisson_ratio
        Table 2 of the article: ``E / (2 G) - 1``.
    """

    youngs_modulus: float = 2.059e11
    poisson_ratio: float = 0.303


@dataclasses.dataclass(frozen=True, kw_only=True)
class ContactParameters(ParameterSet):
    """Wheel/rail contact on real profiles."""

    GROUP = "contact"
    model: str = quantity(
        "profiles",
        "1",
        "profiles: contact of real profiles with creep forces in three dimensions; vertical: "
        "eq. (1) on a level tread at the rolling circle, no creep forces, rails held laterally",
        choices=("vertical", "profiles"),
    )
    wheel_profile: str = quantity(
        "S1002",
        "1",
        "Wheel profile: S1002, or the path of a file with two columns, lateral coordinate "
        "and height in mm (flange at negative y, z down)",
        source="EN 13715",
    )
    rail_profile: str = quantity(
        "CHN60",
        "1",
        "Rail profile: 60E1, CHN60, 60E1_manchester, or the path of a file with two columns, "
        "lateral coordinate and height in mm (gauge side at negative y, z down)",
        source="the article's lines have the Chinese 60 kg/m rail",
    )
    profile_noise: float = quantity(
        0.0,
        "m",
        "Standard deviation of the heights in profile files: the smoothing leaves residuals of "
        "this size; 0 goes through every point",
        at_least=0.0,
        at_most=1e-3,
    )
    friction_coefficient: float = quantity(
        0.3,
        "1",
        "Coefficient of friction of wheel and rail",
        symbol="mu",
        at_least=0.0,
        at_most=1.0,
    )
    hertz_constant: float = quantity(
        0.0,
        "m/N^(2/3)",
        "Hertz constant of eq. (1) for every patch; 0 takes it from the profiles' curvatures, "
        "with contact.model = vertical 3.86e-8 R^-0.115 of a worn tread of radius R",
        symbol="G_H",
        at_least=0.0,
        at_most=1e-5,
    )
    wheel_radius: float = quantity(
        0.46, "m", "Nominal rolling radius of the wheels", symbol="R_w", at_least=0.1, at_most=1.0
    )
    rolling_circle_distance: float = quantity(
        1.493,
        "m",
        "Lateral distance of the two rolling circles",
        at_least=0.5,
        at_most=2.5,
        source="Chinese standard-gauge lines, wheels 1353 mm back to back; European wheelsets "
        "with 1360 mm have 1.5",
    )
    reference_penetration: float = quantity(
        7e-5,
        "m",
        "Overlap of the profiles over which position, angle and curvature of a patch are "
        "averaged; that of the static load, smaller towards rigid contact points",
        at_least=1e-7,
        at_most=5e-4,
        source="approach under the static wheel load of 69 kN",
    )
    fastsim_columns: int = quantity(
        10, "1", "Cells of FASTSIM along the slip zone of a strip", at_least=2, at_most=1000
    )
    fastsim_strips: int = quantity(
        8, "1", "Strips of FASTSIM across the rolling direction", at_least=2, at_most=1000
    )

    @property
    def hertz_constant_used(self) -> float:
        """The constant of eq. (1) for the vertical model, m/N^(2/3) (worn tread: Zhai)."""
        return self.hertz_constant or 3.86e-8 * self.wheel_radius**-0.115

    def placement(
        self, gauge: float, gauge_measurement_depth: float, cant: float, rail_axis_depth: float
    ) -> RailPlacement:
        """Return the placement of wheels and rails for a track's gauge and inclination."""
        return RailPlacement(
            gauge=gauge,
            gauge_depth=gauge_measurement_depth,
            cant=cant,
            rolling_circle_distance=self.rolling_circle_distance,
            wheel_radius=self.wheel_radius,
            axis_depth=rail_axis_depth,
        )

"""Parameters of the slab track: Table 2 of the article, HD line, by default.

The article is "Study on Steady-State Responses of High-Speed Vehicle Using
Infinite Long Track Model"; values without another source are its Table 2.
"""

import dataclasses
import math

from rail_quantities import ParameterError, ParameterSet, quantity

from slab_track.contact.parameters import ContactParameters
from slab_track.irregularity import IrregularityParameters
from slab_track.waves import samples_per_bay

WHEELSET_LIMIT = 4
"""Largest number of wheelset terminals."""

WHEELSET_PLACES = (0.0, 2.5, 17.8, 20.3)
"""Distance of the article's wheelsets behind the leading one, m."""

_EXTENT = (0.0, *WHEELSET_PLACES)
"""Distance of the outer ones of so many wheelsets, m."""

SHORTEST_WAVE = 0.51
"""Wavelength at which the rail's modal series ends by default, m: its waves reach to 3.8 kHz."""

_FEWEST_MODES, _MOST_MODES = 8, 4000

_LONGEST_END_ZONE = 0.4
"""Part of the window."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Rail(ParameterSet):
    """One rail: a Timoshenko beam, hinged at the ends of the window."""

    GROUP = "rail"
    youngs_modulus: float = quantity(
        2.059e11, "Pa", "Young's modulus of the rail", symbol="E", above=0.0
    )
    shear_modulus: float = quantity(
        7.9e10, "Pa", "Shear modulus of the rail", symbol="G", above=0.0
    )
    density: float = quantity(7860.0, "kg/m3", "Density of the rail", symbol="rho", above=0.0)
    area: float = quantity(
        7.745e-3, "m2", "Cross-sectional area of the rail", symbol="A", above=0.0
    )
    vertical_second_moment: float = quantity(
        3.217e-5, "m4", "Second moment of area for vertical bending", symbol="I_y", above=0.0
    )
    vertical_shear_coefficient: float = quantity(
        0.5329,
        "1",
        "Timoshenko shear coefficient, vertical",
        symbol="kappa_z",
        above=0.0,
        at_most=1.0,
    )
    lateral_second_moment: float = quantity(
        5.24e-6,
        "m4",
        "Second moment of area for lateral bending",
        symbol="I_z",
        above=0.0,
        source="CHN60 section",
    )
    lateral_shear_coefficient: float = quantity(
        0.4507,
        "1",
        "Timoshenko shear coefficient, lateral",
        symbol="kappa_y",
        above=0.0,
        at_most=1.0,
        source="usual value of the CHN60 section in vehicle/track models",
    )
    polar_second_moment: float = quantity(
        3.741e-5,
        "m4",
        "Polar second moment of area, for the rotary inertia of torsion",
        symbol="I_0",
        above=0.0,
        source="CHN60 section: sum of both second moments",
    )
    torsional_stiffness: float = quantity(
        1.96e5,
        "N.m2",
        "Saint-Venant torsional stiffness",
        symbol="G K",
        above=0.0,
        source="CHN60 section",
    )
    base_width: float = quantity(
        0.150, "m", "Width of the rail base on the pad", above=0.0, source="CHN60 section"
    )
    axis_height: float = quantity(
        0.081,
        "m",
        "Height of the rail's axis (centroid) above its base",
        above=0.0,
        source="CHN60 section",
    )
    axis_depth: float = quantity(
        0.095,
        "m",
        "Depth of the rail's axis below the top of its head",
        above=0.0,
        source="CHN60 section: 176 mm high",
    )
    gauge: float = quantity(
        1.435, "m", "Distance of the rails' inner faces", at_least=0.5, at_most=2.5
    )
    gauge_measurement_depth: float = quantity(
        0.016,
        "m",
        "Depth below the heads at which the gauge is measured",
        above=0.0,
        at_most=0.03,
        source="Chinese lines; European lines use 0.014",
    )
    cant: float = quantity(
        0.025, "1", "Inclination of the rails towards the track's centre", at_least=0.0, at_most=0.1
    )
    motion: str = quantity(
        "full",
        "1",
        "full: the rails bend vertically and laterally and twist; vertical: they are held "
        "laterally and in roll",
        choices=("full", "vertical"),
    )
    mode_count: int = quantity(
        0,
        "1",
        "Number of wave numbers of the rail's modal series, two branches each; 0 takes all waves "
        f"longer than {SHORTEST_WAVE:g} m, in a window of any length",
        symbol="N_V",
        at_least=0,
        at_most=_MOST_MODES,
    )
    residual_compliance: bool = quantity(
        True,
        "1",
        "Add the static compliance of the rail modes left out, at fasteners and wheels",
    )
    passage_width: float = quantity(
        0.15,
        "1",
        "Last part of the vertical wave numbers over which the modes pass smoothly into their "
        "static compliance; 0: they end at once. Needs rail.residual_compliance",
        at_least=0.0,
        at_most=1.0,
    )

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio of the rail steel from both moduli."""
        return 0.5 * self.youngs_modulus / self.shear_modulus - 1.0

    def modes_over(self, length: float) -> int:
        """Return the number of wave numbers on ``length`` metres, given or derived."""
        return self.mode_count or max(1, math.floor(2.0 * length / SHORTEST_WAVE))

    def last_wave_number(self, length: float) -> float:
        """Return where the modal series on ``length`` metres ends, rad/m."""
        shortest = 2.0 * length / self.mode_count if self.mode_count else SHORTEST_WAVE
        return 2.0 * math.pi / shortest


@dataclasses.dataclass(frozen=True, kw_only=True)
class Fastener(ParameterSet):
    """Rail pads and fasteners, one per rail seat."""

    GROUP = "fastener"
    spacing: float = quantity(
        0.629,
        "m",
        "Distance of neighbouring fasteners (sleeper bay)",
        symbol="l_0",
        at_least=0.1,
        at_most=5.0,
    )
    count_per_slab: int = quantity(8, "1", "Fasteners per slab and rail", at_least=1, at_most=40)
    vertical_stiffness: float = quantity(
        40e6, "N/m", "Vertical stiffness of one fastener", symbol="K_pv", above=0.0, nominal=40e6
    )
    vertical_damping: float = quantity(
        52e3, "N.s/m", "Vertical damping of one fastener", symbol="C_pv", at_least=0.0, nominal=50e3
    )
    lateral_stiffness: float = quantity(
        15e6,
        "N/m",
        "Lateral stiffness of one fastener at the rail base",
        symbol="K_pl",
        above=0.0,
        nominal=15e6,
        source="usual value of slab-track fasteners; not printed in the article",
    )
    lateral_damping: float = quantity(
        50e3,
        "N.s/m",
        "Lateral damping of one fastener at the rail base",
        symbol="C_pl",
        at_least=0.0,
        nominal=50e3,
        source="usual value of slab-track fasteners; not printed in the article",
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Slab(ParameterSet):
    """One slab: a free rectangular elastic plate in modal coordinates."""

    GROUP = "slab"
    length: float = quantity(
        0.0,
        "m",
        "Length of a slab; 0 takes fastener.count_per_slab * fastener.spacing - slab.gap",
        symbol="L_s",
        at_least=0.0,
    )
    width: float = quantity(2.5, "m", "Width of a slab", symbol="D_s", above=0.0, at_most=20.0)
    thickness: float = quantity(
        0.17, "m", "Thickness of a slab", symbol="H_s", above=0.0, at_most=5.0
    )
    density: float = quantity(2800.0, "kg/m3", "Density of the slab", symbol="rho_s", above=0.0)
    youngs_modulus: float = quantity(
        3.6e10, "Pa", "Young's modulus of the slab", symbol="E_s", above=0.0
    )
    poisson_ratio: float = quantity(
        0.2,
        "1",
        "Poisson's ratio of the slab",
        symbol="nu_s",
        at_least=0.0,
        below=0.5,
        source="usual value of concrete; not printed in the article",
    )
    damping_ratio: float = quantity(
        0.0,
        "1",
        "Modal damping ratio of the elastic slab modes, eq. (7)",
        symbol="zeta_n",
        at_least=0.0,
        below=1.0,
        source="not printed in the article; the damping of the CAM layer dominates",
    )
    gap: float = quantity(
        0.070,
        "m",
        "Gap between neighbouring slabs; used when slab.length is 0",
        at_least=0.0,
        source="difference of the bays' length and the slab length in Table 2",
    )
    mode_count: int = quantity(
        60,
        "1",
        "Plate modes per slab, the three rigid ones included",
        at_least=3,
        at_most=600,
    )
    residual_compliance: bool = quantity(
        True,
        "1",
        "Add the static compliance of the plate modes left out, at the rail seats",
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class SlabSupport(ParameterSet):
    """The cement-asphalt-mortar (CAM) layer under the slab."""

    GROUP = "slab_support"
    vertical_stiffness: float = quantity(
        5000e6, "N/m", "Vertical stiffness of the layer per basis", symbol="K_sv", above=0.0
    )
    vertical_damping: float = quantity(
        300e3, "N.s/m", "Vertical damping of the layer per basis", symbol="C_sv", at_least=0.0
    )
    basis: str = quantity(
        "per_bay",
        "1",
        "What stiffness and damping of the layer refer to; a bay carries both rails. "
        "The values are then per bay, seat, slab, metre of line or square metre",
        choices=("per_bay", "per_seat", "per_slab", "per_metre", "per_square_metre"),
        source="not said in the article; its Table 3 comes out with per_bay",
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Window(ParameterSet):
    """The piece of track that moves along with the vehicle."""

    GROUP = "window"
    slab_count: int = quantity(16, "1", "Slabs in the window", at_least=3, at_most=200)
    method: str = quantity(
        "sliding",
        "1",
        "sliding: the window follows the vehicle; cyclic: so it does, and its ends are joined "
        "to a ring, so that nothing is cut off; moving_mass: it stays, and the run ends before "
        "a wheel comes too near to its end; moving_irregularity: the vehicle stays on the middle "
        "of the window and the irregularity runs past it",
        choices=("sliding", "cyclic", "moving_mass", "moving_irregularity"),
    )
    vehicle_offset: float = quantity(
        -3.0,
        "m",
        "Shift of the vehicle in a window that follows it, from the middle towards the front end "
        "(negative: more track ahead than behind); it moves the instants of the window shifts",
        at_least=-50.0,
        at_most=50.0,
    )
    end_damping: float = quantity(
        100e3,
        "N.s/m",
        "Vertical damping added to the fasteners at the ends of the window, falling to nothing "
        "well before the wheels, so that waves do not come back; 0: none. Without effect with "
        "window.method = moving_mass, whose wheels come near to the ends",
        at_least=0.0,
    )
    slide_solver: str = quantity(
        "least_squares",
        "1",
        "How eq. (10) is solved: least_squares, eq. (11); projection, its limit for M to infinity, "
        "mass-weighted; constrained, least squares that keep deflection, velocity and acceleration "
        "of the rails under the wheels exactly; triangular (as many samples as "
        "modes; it diverges within a few window shifts and is there to show that)",
        choices=("least_squares", "projection", "constrained", "triangular"),
    )
    slide_pitches: int = quantity(
        1, "1", "Slab pitches of one window shift", at_least=1, at_most=10
    )
    rear_taper: float = quantity(
        0.0,
        "m",
        "Rear transition: length at the rear end of the window over which a window shift lets the "
        "rails' motion fall smoothly to nothing; 0: none",
        at_least=0.0,
        at_most=50.0,
    )
    sample_count: int = quantity(
        0,
        "1",
        "Sample points of the least squares along the window; 0 takes the fasteners and as many "
        "between them as give at least 6/5 of rail.mode_count",
        symbol="M",
        at_least=0,
        at_most=20000,
    )


LONGEST_LEVEL_STEP = 2e-4
"""Longest internal step of the level contact, s: the trapezoidal rule does not damp its bounce."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Integration(ParameterSet):
    """Time integration inside the track."""

    GROUP = "integration"
    maximum_step: float = quantity(
        1e-4,
        "s",
        "Largest internal step; a communication step is divided into equal parts of at most this",
        at_least=1e-7,
        at_most=1e-3,
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class TrackParameters(ParameterSet):
    """All parameters of the track, grouped as their dotted names are."""

    rail: Rail = dataclasses.field(default_factory=Rail)
    fastener: Fastener = dataclasses.field(default_factory=Fastener)
    slab: Slab = dataclasses.field(default_factory=Slab)
    slab_support: SlabSupport = dataclasses.field(default_factory=SlabSupport)
    window: Window = dataclasses.field(default_factory=Window)
    contact: ContactParameters = dataclasses.field(default_factory=ContactParameters)
    irregularity: IrregularityParameters = dataclasses.field(default_factory=IrregularityParameters)
    integration: Integration = dataclasses.field(default_factory=Integration)
    static_wheel_load: float = quantity(
        69214.4,
        "N",
        "Static load of one wheel; the line is in equilibrium under it at the start",
        at_least=0.0,
        nominal=7e4,
        source="an eighth of the weight of the article's vehicle, 9.81 m/s2",
    )
    interface: str = quantity(
        "contact",
        "1",
        "contact: wheelset motion in, contact forces out; applied_force: forces at the rail "
        "heads in, motion of the rails out",
        choices=("contact", "applied_force"),
    )
    wheelset_count: int = quantity(
        4, "1", "Number of wheelset terminals in use", at_least=1, at_most=WHEELSET_LIMIT
    )
    initial_position: float = quantity(
        0.0,
        "m",
        "Start of the leading wheelset where no longitudinal position is given",
    )

    @property
    def pitch(self) -> float:
        """Length of one slab and one gap along the line, m."""
        return self.fastener.count_per_slab * self.fastener.spacing

    @property
    def slab_length(self) -> float:
        """Length of a slab in m, given or derived from the fasteners."""
        return self.slab.length or self.pitch - self.slab.gap

    @property
    def window_length(self) -> float:
        """Length l of the window, m."""
        return self.window.slab_count * self.pitch

    @property
    def fastener_count(self) -> int:
        """Fasteners per rail in the window."""
        return self.window.slab_count * self.fastener.count_per_slab

    @property
    def slide_length(self) -> float:
        """Distance of one window shift, m."""
        return self.window.slide_pitches * self.pitch

    @property
    def rail_mode_count(self) -> int:
        """Wave numbers N_V of the rail's modal series in the window."""
        return self.rail.modes_over(self.window_length)

    @property
    def ring(self) -> bool:
        """True if the window's ends are joined."""
        return self.window.method == "cyclic"

    @property
    def end_zones(self) -> tuple[float, float]:
        """Length at the rear and the front of the window with added damping, m; 0: none.

        Both end 2 m before the wheels of the article's vehicle, as they stand nearer to an
        end at the worst instant: so the window is its own mirror image.
        """
        if self.window.method == "moving_mass" or self.window.end_damping == 0.0:
            return 0.0, 0.0
        room = 0.5 * (self.window_length - self.slide_length - _EXTENT[self.wheelset_count])
        offset, most = self.window.vehicle_offset, _LONGEST_END_ZONE * self.window_length
        zone = min(most, max(0.0, room - abs(offset) - 2.0))
        return zone, zone

    @property
    def moves(self) -> bool:
        """True if the window follows the vehicle."""
        return self.window.method in ("sliding", "cyclic")

    @property
    def sample_count(self) -> int:
        """Sample points M of the window shift."""
        count = self.rail_mode_count
        if self.window.slide_solver == "triangular":
            return self.window.sample_count or count
        bay = samples_per_bay(count, self.fastener_count)
        return self.window.sample_count or bay * self.fastener_count

    @property
    def support_per_area(self) -> tuple[float, float]:
        """Stiffness (N/m3) and damping (N.s/m3) of the CAM layer per square metre of slab."""
        bay = self.fastener.spacing * self.slab.width
        area = {
            "per_bay": bay,
            "per_seat": 0.5 * bay,
            "per_slab": self.slab_length * self.slab.width,
            "per_metre": self.slab.width,
            "per_square_metre": 1.0,
        }[self.slab_support.basis]
        support = self.slab_support
        return support.vertical_stiffness / area, support.vertical_damping / area

    def check(self) -> None:
        """Check the rules between several parameters."""
        first_seat = 0.5 * (self.pitch - self.slab_length)
        if self.slab_length > self.pitch or self.slab_length <= 0.0:
            raise ParameterError(
                "slab.length",
                self.slab_length,
                f"must be above 0 and at most the {self.pitch:g} m between slabs",
                "change slab.length, slab.gap, fastener.spacing or fastener.count_per_slab",
            )
        if 0.5 * self.fastener.spacing <= first_seat:
            raise ParameterError(
                "slab.gap",
                self.pitch - self.slab_length,
                f"must be less than the {self.fastener.spacing:g} m between fasteners",
                "the outer fasteners would stand beside the slab",
            )
        if self.contact.rolling_circle_distance >= self.slab.width:
            raise ParameterError(
                "slab.width",
                self.slab.width,
                f"must be more than the {self.contact.rolling_circle_distance:g} m between rails",
                "widen the slab or reduce contact.rolling_circle_distance",
            )
        self._check_modes()
        self._check_samples()
        self._check_step()
        rail = self.rail
        if self.contact.model == "profiles" and not 0.0 <= rail.poisson_ratio < 0.5:
            raise ParameterError(
                "rail.shear_modulus",
                rail.shear_modulus,
                f"must be from {rail.youngs_modulus / 3:.4g} to {rail.youngs_modulus / 2:.4g} Pa "
                "for this rail.youngs_modulus",
                "Poisson's ratio E/(2 G) - 1 must lie between 0 and 0.5 for the contact",
            )

    def _check_modes(self) -> None:
        count = self.rail.mode_count
        if 0 < count < _FEWEST_MODES:
            raise ParameterError(
                "rail.mode_count",
                count,
                f"must be at least {_FEWEST_MODES}, or 0",
                f"0 takes all waves longer than {SHORTEST_WAVE:g} m",
            )
        if self.rail_mode_count > _MOST_MODES:
            raise ParameterError(
                "window.slab_count",
                self.window.slab_count,
                f"must be less: a window of {self.window_length:g} m takes {self.rail_mode_count} "
                f"rail modes, at most {_MOST_MODES} are possible",
                "reduce window.slab_count, or set rail.mode_count",
            )

    def _check_step(self) -> None:
        step, level = self.integration.maximum_step, self.contact.model == "vertical"
        if level and self.interface == "contact" and step > LONGEST_LEVEL_STEP:
            raise ParameterError(
                "integration.maximum_step",
                step,
                f"must be at most {LONGEST_LEVEL_STEP:g} s with contact.model = vertical",
                "from 0.4 ms on the wheels of this model bounce from step to step on smooth rails; "
                "take a smaller internal step (the communication step may be longer)",
            )

    def _check_samples(self) -> None:
        count, modes = self.window.sample_count, self.rail_mode_count
        if count and self.window.slide_solver == "triangular" and count != modes:
            raise ParameterError(
                "window.sample_count",
                count,
                f"must equal rail.mode_count = {modes} with the triangular solver",
                "set it to 0, or take window.slide_solver = least_squares",
            )
        if count and count <= modes and self.window.slide_solver == "least_squares":
            raise ParameterError(
                "window.sample_count",
                count,
                f"must be more than rail.mode_count = {modes} for a least-squares fit",
                "set it to 0 for the default",
            )

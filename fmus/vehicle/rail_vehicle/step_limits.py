"""How long a communication step may be when the vehicle is coupled with a track.

The vehicle and the contact of its wheels with rails form a loop that the coupling closes once in a
step. Its two rates are those of a wheel on a rigid rail of steel: ``omega`` of the wheel on
the contact's stiffness ``k``, and ``lambda`` at which creep brings a spinning wheelset to
pure rolling at speed ``V``,

    omega^2 = 2 k / m,    lambda = 2 f_11 (R^2 / J + 1 / m) / V,

with ``k = 1.5 N^(1/3) / G_H``, ``G_H = 3.86e-8 R^-0.115``, and Kalker's
``f_11 = C_11 G a^2`` of a round patch of radius ``a = k (1 - nu^2) / E``. The products with
the step at which the largest eigenvalue of the loop's discrete equations leaves the unit circle
are numbers of the algorithm alone (docs/theory.md, section 10).
"""

import dataclasses
import math

from rail_vehicle.parameters import VehicleParameters

LARGEST_EXTRAPOLATION_ERROR = 0.15
"""Of the parabola, see :attr:`rail_vehicle.coupling.ForceHistory.extrapolation_errors`."""

_YOUNGS_MODULUS, _POISSON_RATIO, _C11 = 2.1e11, 0.3, 4.1
_SHEAR_MODULUS = 0.5 * _YOUNGS_MODULUS / (1.0 + _POISSON_RATIO)
_LEVER = 0.75  # m, half the distance of the rolling circles

_STABLE = {True: (1.55, 1.1), False: (0.55, 0.22)}
_ACCURATE = {True: 0.27, False: 0.13}
"""Largest products of the step with omega and lambda by whether inputs stand for the end of
the step; the accurate ones keep the error of the wheel force near 1 % of its amplitude."""


@dataclasses.dataclass(frozen=True)
class StepLimits:
    """Largest communication steps of a coupled vehicle.

    Attributes
    ----------
    parameters
        Of the vehicle.
    at_end
        Whether the forces given to a step stand for its end: Gauss-Seidel, otherwise Jacobi.
    """

    parameters: VehicleParameters
    at_end: bool

    @property
    def contact_stiffness(self) -> float:
        """Of a wheel under its static load, N/m."""
        p = self.parameters
        hertz_constant = 3.86e-8 * p.wheelset.radius**-0.115
        return 1.5 * p.static_wheel_load ** (1.0 / 3.0) / hertz_constant

    @property
    def contact_rate(self) -> float:
        """Angular frequency of the wheelset on its contact springs, rad/s."""
        return math.sqrt(2.0 * self.contact_stiffness / self.parameters.wheelset.mass)

    @property
    def creep_rate(self) -> float:
        """Rate at which longitudinal creep decays at the initial speed, 1/s."""
        wheelset, speed = self.parameters.wheelset, max(self.parameters.speed, 1.0)
        radius = self.contact_stiffness * (1.0 - _POISSON_RATIO**2) / _YOUNGS_MODULUS
        creep = _C11 * _SHEAR_MODULUS * radius**2
        mobility = wheelset.radius**2 / wheelset.pitch_inertia + 1.0 / wheelset.mass
        return 2.0 * creep * mobility / speed

    @property
    def stable(self) -> float:
        """Largest step of a stable coupling, s."""
        contact, creep = _STABLE[self.at_end]
        return min(contact / self.contact_rate, creep / self.creep_rate)

    @property
    def accurate(self) -> float:
        """Largest step of an accurate coupling, s."""
        return min(_ACCURATE[self.at_end] / self.contact_rate, self.stable)

    @property
    def unit(self) -> tuple[float, ...]:
        """Forces and moments on a wheelset that its static load makes, N and N.m, six numbers."""
        force = 2.0 * self.parameters.static_wheel_load
        turn, spin = force * _LEVER, force * self.parameters.wheelset.radius
        return (force, force, force, turn, spin, turn)

    def _remedy(self) -> str:
        inputs = "step_end" if self.at_end else "step_start"
        text = (
            f"take at most {self.accurate * 1e3:.2g} ms (error 1 %; stable to some "
            f"{self.stable * 1e3:.2g} ms) with coupling.input_time = {inputs} at "
            f"{self.parameters.speed:.3g} m/s"
        )
        if self.at_end:
            return text
        return f"{text}, or step the track first and give its new forces to the vehicle (step_end)"

    def warning(self, step: float) -> str:
        """Say that ``step`` (s) is too coarse to be accurate."""
        return f"communication step {step * 1e3:g} ms is coarse for a track: {self._remedy()}"

    def error(self, step: float) -> str:
        """Say that the coupling is not stable with ``step`` (s)."""
        return (
            "the contact forces turn from step to step: with a communication step of "
            f"{step * 1e3:g} ms the coupling is unstable, or does not resolve what excites the "
            f"wheels; {self._remedy()}"
        )

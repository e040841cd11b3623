r"""The linear track of one window: two rails, fasteners, slabs on their CAM layer.

The line is mirror-symmetric about its middle plane. With the orthonormal
combinations :math:`f_s=(f_L+f_R)/\sqrt2` and :math:`f_a=(f_R-f_L)/\sqrt2` of
everything that exists left and right, the track falls into two systems that do
not know each other: the symmetric one with the slab modes even in y (bounce,
pitch, bending) and the antisymmetric one with the odd ones (roll, twist).

Waves that look alike at the fasteners are summed together (:mod:`slab_track.waves`).

The shortest waves follow their forces without inertia. The passage is smooth: of wave
number kappa the share s(kappa) of the compliance is that of the moving modes, the rest is
static. A sharp end of the modal series would surround every force with a ripple that dies
out like 1/x, along the whole window; it is cut off when the window slides.
"""

import functools
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rail_quantities import kept_array

from slab_track.parameters import TrackParameters
from slab_track.plate import PlateModes, free_plate_modes, seat_compliance
from slab_track.rail import RailModes, static_flexibility, vertical_modes
from slab_track.waves import Waves, fastener_shapes, fold_table, waves

SYMMETRIC, ANTISYMMETRIC = 0, 1

FINEST_WAVES_PER_BAY = 60
"""Wave numbers per fastener bay up to which the residual is summed (2 cm wavelength)."""


class SlabSystem(NamedTuple):
    """Slab modes of one symmetry class on the CAM layer, alike for every slab.

    Attributes
    ----------
    omega_squared
        Plate and layer together, rad2/s2, shape (n,).
    damping
        Twice the modal damping rate, 1/s, shape (n,).
    seats
        Shape at the rail seats times sqrt(2) for the pair of rails, kg^-1/2, shape (n, C).
    residual
        Static compliance at the seats of the modes left out, m/N, shape (C, C).
    """

    omega_squared: np.ndarray
    damping: np.ndarray
    seats: np.ndarray
    residual: np.ndarray


class LinearTrack(NamedTuple):
    """Everything linear in a window, ready for statics, stepping and receptances.

    Attributes
    ----------
    rail
        Modes of one rail (the same for both symmetry classes).
    slabs
        Symmetric and antisymmetric slab system.
    participation
        Deflection of the rail per unit modal coordinate as forces feel it, (2, N): the modes'
        own, times the root of the share s.
    fastener_sines
        Shapes of the first P waves at the fasteners, (P, P): row wave, column fastener.
    fold_index, fold_sign
        For every wave the row of ``fastener_sines`` it repeats and its sign
        (0 where the shape vanishes at all fasteners), shape (N,).
    fine
        The waves whose compliance is static, wholly or in part: the first R waves.
    residual_flexibility
        Their static deflection per unit wave force, m/N, shape (R,); zero where the modes move
        with their full share, empty without residual compliance.
    stiffness, damping
        Of one fastener, N/m and N.s/m.
    end_damping
        What is added to each fastener's damping, N.s/m, (P,): towards the window's ends.
    slab_count, seat_count
        Slabs in the window, fasteners per slab and rail.
    length
        Length of the window, m.
    """

    rail: RailModes
    participation: np.ndarray
    slabs: tuple[SlabSystem, SlabSystem]
    fastener_sines: np.ndarray
    fold_index: np.ndarray
    fold_sign: np.ndarray
    fine: Waves
    residual_flexibility: np.ndarray
    stiffness: float
    damping: float
    end_damping: np.ndarray
    slab_count: int
    seat_count: int
    length: float

    @property
    def fastener_count(self) -> int:
        """Fasteners per rail in the window, P."""
        return self.slab_count * self.seat_count

    def fold(self, amplitudes: np.ndarray) -> np.ndarray:
        """Sum wave amplitudes (N, ...) of equal shape at the fasteners into (P, ...)."""
        folded = np.zeros((self.fastener_count, *amplitudes.shape[1:]))
        signed = amplitudes * self.fold_sign.reshape(-1, *[1] * (amplitudes.ndim - 1))
        np.add.at(folded, self.fold_index, signed)
        return folded

    def unfold(self, folded: np.ndarray) -> np.ndarray:
        """Transpose of :meth:`fold`."""
        sign = self.fold_sign.reshape(-1, *[1] * (folded.ndim - 1))
        return folded[self.fold_index] * sign

    @property
    def pitch(self) -> float:
        """Length of one slab and one gap, m."""
        return self.length / self.slab_count

    @property
    def ring(self) -> bool:
        """True if the track closes on itself."""
        return self.rail.waves.ring

    def wave_shapes(self, x: np.ndarray) -> np.ndarray:
        """Return the shapes of the modal waves at positions x in the window, (N, points)."""
        return self.rail.waves.shapes(x)

    def fastener_admittance(
        self, rail_weight: np.ndarray, slab_weight: np.ndarray, symmetry: int
    ) -> np.ndarray:
        """Return Z^T diag(weight) Z at the fasteners, rail plus slab, shape (P, P).

        ``rail_weight`` (2, N) and ``slab_weight`` (n,) are response per unit modal
        force: 1/omega2 gives the static compliance, the integrator's own weight the
        response within a step.
        """
        beta = np.sum(self.participation**2 * rail_weight, axis=0)
        classes = np.zeros(self.fastener_count)
        np.add.at(classes, self.fold_index, beta * self.fold_sign**2)
        seats = self.slabs[symmetry].seats
        return self._over_fasteners(classes, seats.T @ (slab_weight[:, None] * seats))

    def fastener_residual(self, symmetry: int) -> np.ndarray:
        """Return the static compliance of all modes left out at the fasteners, (P, P), m/N."""
        count, classes = self.residual_flexibility.size, np.zeros(self.fastener_count)
        index, sign = fold_table(count, self.fastener_count, ring=self.ring)
        np.add.at(classes, index[:count], (self.residual_flexibility * sign[:count] ** 2))
        return self._over_fasteners(classes, self.slabs[symmetry].residual)

    def _over_fasteners(self, classes: np.ndarray, block: np.ndarray) -> np.ndarray:
        """Rail part by folded wave numbers (P,) and slab part (C, C), over all fasteners."""
        rail = self.fastener_sines.T @ (classes[:, None] * self.fastener_sines)
        return rail + np.kron(np.eye(self.slab_count), block)


def plate_modes(parameters: TrackParameters) -> PlateModes:
    """Return the modes of one free slab."""
    slab = parameters.slab
    return free_plate_modes(
        length=parameters.slab_length,
        width=slab.width,
        thickness=slab.thickness,
        youngs_modulus=slab.youngs_modulus,
        poisson_ratio=slab.poisson_ratio,
        density=slab.density,
        count=slab.mode_count,
    )


def _slab_systems(parameters: TrackParameters) -> tuple[SlabSystem, SlabSystem]:
    slab, fastener = parameters.slab, parameters.fastener
    plate = plate_modes(parameters)
    stiffness, damping = parameters.support_per_area
    mass_per_area = slab.density * slab.thickness
    # A uniform layer is proportional to the plate's mass: it shifts every mode alike.
    omega_squared = plate.omega_squared + stiffness / mass_per_area
    rate = 2.0 * slab.damping_ratio * np.sqrt(plate.omega_squared) + damping / mass_per_area
    seats_x = (np.arange(fastener.count_per_slab) + 0.5) * fastener.spacing - 0.5 * parameters.pitch
    right = np.full_like(seats_x, 0.5 * parameters.contact.rolling_circle_distance)
    shapes = np.sqrt(2.0) * plate.shapes(seats_x, right)
    residual = [np.zeros((seats_x.size, seats_x.size)) for _ in range(2)]
    if slab.residual_compliance:
        arguments = {
            "length": parameters.slab_length,
            "width": slab.width,
            "thickness": slab.thickness,
            "youngs_modulus": slab.youngs_modulus,
            "poisson_ratio": slab.poisson_ratio,
            "foundation": stiffness,
            "offset": float(right[0]),
        }
        residual = list(
            kept_array(
                "plate",
                (arguments, seats_x.tolist()),
                lambda: np.stack(seat_compliance(seats=seats_x, **arguments)),
                Path(__file__).parent,
            )
        )
    systems = []
    for symmetry, of in enumerate((plate.even, ~plate.even)):
        seats = np.ascontiguousarray(shapes[of])
        if slab.residual_compliance:
            residual[symmetry] = _positive(
                residual[symmetry] - (seats.T / omega_squared[of]) @ seats
            )
        systems.append(SlabSystem(omega_squared[of], rate[of], seats, residual[symmetry]))
    return systems[0], systems[1]


def _positive(compliance: np.ndarray) -> np.ndarray:
    """Drop the negative eigenvalues that rounding leaves in a compliance matrix."""
    values, vectors = np.linalg.eigh(0.5 * (compliance + compliance.T))
    return (vectors * np.maximum(values, 0.0)) @ vectors.T


@functools.lru_cache(maxsize=2)  # runs at several speeds in one process, as in a sweep
def assemble(parameters: TrackParameters) -> LinearTrack:
    """Build the linear track of a window from its parameters; the last ones are kept."""
    count, ring = parameters.fastener_count, parameters.ring
    length, modes = parameters.window_length, parameters.rail_mode_count
    rail = vertical_modes(parameters.rail, length, ring=ring)
    index, sign = fold_table(modes, count, ring=ring)
    fine = waves(length, max(FINEST_WAVES_PER_BAY * count, 2 * modes), ring=ring)
    share, residual = np.ones(rail.wave_number.size), np.zeros(0)
    if parameters.rail.residual_compliance:
        last = parameters.rail.last_wave_number(length)
        share = moving_share(rail.wave_number, last, parameters.rail.passage_width)
        residual = np.zeros(fine.wave_number.size)
        moving = np.concatenate([share, np.zeros(residual.size - share.size)])
        static = moving < 1.0
        residual[static] = (1.0 - moving[static]) * static_flexibility(
            parameters.rail, length, fine.wave_number[static]
        )
    return LinearTrack(
        rail=rail,
        participation=np.sqrt(share) * rail.deflection,
        slabs=_slab_systems(parameters),
        fastener_sines=fastener_shapes(count, ring=ring),
        fold_index=index,
        fold_sign=sign,
        fine=fine,
        residual_flexibility=residual,
        stiffness=parameters.fastener.vertical_stiffness,
        damping=parameters.fastener.vertical_damping,
        end_damping=_end_damping(parameters),
        slab_count=parameters.window.slab_count,
        seat_count=parameters.fastener.count_per_slab,
        length=length,
    )


def _end_damping(parameters: TrackParameters) -> np.ndarray:
    """Return what is added to each fastener's damping, N.s/m, (P,); rises with the cube."""
    places = (np.arange(parameters.fastener_count) + 0.5) * parameters.fastener.spacing
    depth = np.zeros(places.size)
    to_ends = places, parameters.window_length - places
    for to_end, zone in zip(to_ends, parameters.end_zones, strict=True):
        if zone > 0.0:
            depth = np.maximum(depth, np.clip(1.0 - to_end / zone, 0.0, 1.0))
    return parameters.window.end_damping * depth**3


def moving_share(wave_number: np.ndarray, last: float, width: float) -> np.ndarray:
    """Return the share s of each wave's compliance that moves with inertia, (N,).

    It falls smoothly from 1 to 0 over the last part ``width`` (0 to 1) of the wave numbers up to
    ``last``; 1 for all with ``width`` 0.
    """
    if width == 0.0:
        return np.ones_like(wave_number)
    t = np.clip((wave_number / last - (1.0 - width)) / width, 0.0, 1.0)
    return np.cos(0.5 * np.pi * t) ** 4

r"""The linear track of a window as plain matrices: rails, slabs, fasteners, wheels.

Both rails, all fasteners and all slabs are one second-order system of unit mass,

.. math:: \ddot q + c\,\dot q + K q = W^T F - B^T p,\qquad p = k e + c_p \dot e,\qquad
          e = B q + R_{pF} F - R_{pp}\, p,

q the coordinates of eqs. (6a), (6b), (7) and of lateral bending and torsion; F the wheels' forces
on the rails' axes, p the fasteners' forces, W and B the shapes there, R the static compliance of
the waves and plate modes that the series leave out. Nothing is folded, halved or tabulated over
distance.

Numbers in parentheses are the article's equations; sections are those of ``docs/theory.md``.
w wheelsets, N waves, S slabs, P fasteners per rail; directions of forces on a rail and of its
motion: lateral, vertical, roll; sides: left, right.
"""

import math

import numpy as np
from scipy.linalg import block_diag

from slab_track.assembly import plate_modes
from slab_track.contact.equations import SIDES
from slab_track.parameters import TrackParameters
from slab_track.plate import seat_compliance
from slab_track.rail import static_flexibility
from slab_track.waves import waves

Z, PSI, Y, PSI_Y, PHI = range(5)
"""Fields of a rail: deflection, rotation of the section, the same laterally, torsion."""
LATERAL, VERTICAL, ROLL = range(3)
_WAVES_PER_BAY = 60
"""Waves up to which the static compliance of the rail is summed: 2 cm long."""


def timoshenko(kappa: np.ndarray, EI: float, kGA: float, rho_A: float, rho_I: float) -> np.ndarray:
    """Stiffness (2N, 2N) of the mass-normalised coordinates q_k and w_k, eqs. (2) to (5)."""
    k_qq = kGA / rho_A * kappa**2  # Eq. (6a)
    k_qw = -kGA * kappa / np.sqrt(rho_A * rho_I)  # Eqs. (6a), (6b); rho I, see the errata
    k_ww = kGA / rho_I + EI / rho_I * kappa**2  # Eq. (6b)
    return np.block([[np.diag(k_qq), np.diag(k_qw)], [np.diag(k_qw), np.diag(k_ww)]])


class TrackMatrices:
    """K, c, B, k_p, c_p and R_pp of a window.

    Coordinates are those of the rails, (2, 5, N) with the fields above, then those of the slabs,
    (S, n); fasteners come as (P, 2, 3).
    """

    def __init__(self, parameters: TrackParameters) -> None:
        p = self.p = parameters
        self.plate = plate_modes(p)
        self.waves = waves(p.window_length, p.rail_mode_count, ring=p.ring)
        held = p.rail.motion == "vertical"
        self.held = held or (p.contact.model == "vertical" and p.interface == "contact")
        self._left_out_of_rails()
        # -- stiffness and damping of rails and slabs, each on its own ----------------------
        rail, kappa, slabs = p.rail, self.waves.wave_number, p.window.slab_count
        E, GA, rho = rail.youngs_modulus, rail.shear_modulus * rail.area, rail.density
        I_y, I_z, I_0 = (
            rail.vertical_second_moment,
            rail.lateral_second_moment,
            rail.polar_second_moment,
        )
        vertical = timoshenko(
            kappa, E * I_y, rail.vertical_shear_coefficient * GA, rho * rail.area, rho * I_y
        )
        lateral = timoshenko(
            kappa, E * I_z, rail.lateral_shear_coefficient * GA, rho * rail.area, rho * I_z
        )
        torsion = np.diag(rail.torsional_stiffness / (rho * I_0) * kappa**2)  # section 6
        k_f, c_f = p.support_per_area
        mass, omega_squared = p.slab.density * p.slab.thickness, self.plate.omega_squared
        # Eq. (7): the layer's forces F^g, under all of the plate, are -(k_f X + c_f X')/(rho h).
        self.slab_stiffness = omega_squared + k_f / mass
        slab_damping = 2.0 * p.slab.damping_ratio * np.sqrt(omega_squared) + c_f / mass
        one = block_diag(vertical, lateral, torsion)
        self.K = block_diag(one, one, np.diag(np.tile(self.slab_stiffness, slabs)))
        self.c = np.concatenate([np.zeros(10 * kappa.size), np.tile(slab_damping, slabs)])
        # -- fasteners ----------------------------------------------------------------------
        f, self.x_p = p.fastener, (np.arange(p.fastener_count) + 0.5) * p.fastener.spacing
        lever = rail.base_width**2 / 4.0  # half the vertical spring under either edge, section 6
        k = [f.lateral_stiffness, f.vertical_stiffness, f.vertical_stiffness * lever]
        c = [f.lateral_damping, f.vertical_damping, f.vertical_damping * lever]
        self.k_p, c_p = np.tile(k, 2 * self.x_p.size), np.tile(c, (self.x_p.size, 2, 1))
        for to_end, zone in zip((self.x_p, p.window_length - self.x_p), p.end_zones, strict=True):
            depth = np.clip(1.0 - to_end / zone, 0.0, 1.0) if zone else 0.0 * to_end
            c_p[:, :, VERTICAL] += (p.window.end_damping * depth**3)[:, None]
        self.c_p = c_p.ravel()
        B, R_pp = self._rows(self.x_p), self._between(self.x_p, self.x_p)
        B[:, :, LATERAL] -= rail.axis_height * B[:, :, ROLL]  # the base moves by y - h_f phi
        seats, seat_residual = self._seats()
        on_slabs = B[..., 10 * kappa.size :].reshape(*B.shape[:3], slabs, -1)
        for i, (slab, seat) in enumerate(np.ndindex(slabs, f.count_per_slab)):
            on_slabs[i, :, VERTICAL, slab] = -seats[seat]  # a view into B
            own = slice(slab * f.count_per_slab, (slab + 1) * f.count_per_slab)
            R_pp[i, :, VERTICAL, own, :, VERTICAL] += seat_residual[seat]
        self.B, self.R_pp = B.reshape(c_p.size, -1), R_pp.reshape(c_p.size, -1)

    def _left_out_of_rails(self) -> None:
        """Section 4: of a wave's compliance gamma_k the share s_k moves, 1 - s_k is static."""
        rail, length, kappa = self.p.rail, self.p.window_length, self.waves.wave_number
        count = max(_WAVES_PER_BAY * self.p.fastener_count, 2 * self.p.rail_mode_count)
        self.fine = waves(length, count, ring=self.p.ring)
        self.share, self.gamma = np.ones(kappa.size), np.zeros(self.fine.wave_number.size)
        self.sideways_residual = np.zeros(3)
        if rail.residual_compliance:
            last, width = rail.last_wave_number(length), rail.passage_width
            if width > 0.0:
                t = np.clip((kappa / last - (1.0 - width)) / width, 0.0, 1.0)
                self.share = np.cos(0.5 * np.pi * t) ** 4
            static = np.concatenate([1.0 - self.share, np.ones(self.gamma.size - kappa.size)])
            of = static > 0.0
            self.gamma[of] = static[of] * static_flexibility(
                rail, length, self.fine.wave_number[of]
            )
            # Laterally and in torsion at the wheels only, in the mean over the places.
            far = waves(length, 200 * self.p.rail_mode_count, ring=self.p.ring).wave_number
            k = far[kappa.size :]
            EI = rail.youngs_modulus * rail.lateral_second_moment
            kGA = rail.lateral_shear_coefficient * rail.shear_modulus * rail.area
            self.sideways_residual[LATERAL] = np.sum(1 / (EI * k**4) + 1 / (kGA * k**2)) / length
            self.sideways_residual[ROLL] = np.sum(1 / (rail.torsional_stiffness * k**2)) / length

    def _rows(self, x: np.ndarray) -> np.ndarray:
        """Motion of both rails' axes at ``x``, m in the window: (points, 2, 3, coordinates)."""
        rail, shapes = self.p.rail, self.waves.shapes(x).T
        mean = self.waves.mean_square * self.p.window_length
        Z_k = shapes / np.sqrt(rail.density * rail.area * mean)  # of eq. (4), mass-normalised
        Phi_k = shapes / np.sqrt(rail.density * rail.polar_second_moment * mean)
        one = np.zeros((x.size, 3, 5, self.waves.wave_number.size))
        one[:, LATERAL, Y], one[:, VERTICAL, Z] = Z_k, np.sqrt(self.share) * Z_k
        one[:, ROLL, PHI] = Phi_k
        both = np.zeros((x.size, 2, 3, self.c.size))
        size = one[0, 0].size
        both[:, 0, :, :size] = both[:, 1, :, size : 2 * size] = one.reshape(x.size, 3, size)
        return both

    def _between(self, x: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Deflection at ``x`` per force at ``other`` by what the rails' series leave out."""
        residual = np.zeros((x.size, 2, 3, other.size, 2, 3))
        one = self.fine.shapes(x).T @ (self.gamma[:, None] * self.fine.shapes(other))
        residual[:, 0, VERTICAL, :, 0, VERTICAL] = residual[:, 1, VERTICAL, :, 1, VERTICAL] = one
        return residual

    def _seats(self) -> tuple[np.ndarray, np.ndarray]:
        """Shapes Pi_n of a slab at its seats (C, 2, n); compliance left out there (C, 2, C, 2)."""
        p, slab, count = self.p, self.p.slab, self.p.fastener.count_per_slab
        x = (np.arange(count) + 0.5) * p.fastener.spacing - 0.5 * p.pitch
        half = 0.5 * p.contact.rolling_circle_distance
        seats = np.stack([self.plate.shapes(x, 0.0 * x + s * half).T for s in SIDES], axis=1)
        residual = np.zeros((count, 2, count, 2))
        if slab.residual_compliance:
            whole = seat_compliance(
                length=p.slab_length, width=slab.width, thickness=slab.thickness,
                youngs_modulus=slab.youngs_modulus, poisson_ratio=slab.poisson_ratio,
                foundation=p.support_per_area[0], seats=x, offset=half,
            )  # fmt: skip
            signs = np.array([np.ones((2, 2)), [[1.0, -1.0], [-1.0, 1.0]]])
            for even, sign, compliance in zip((True, False), signs, whole, strict=True):
                of = self.plate.even == even
                pair = math.sqrt(2.0) * seats[:, 1, of]  # both seats together, and against another
                values, vectors = np.linalg.eigh(
                    compliance - pair / self.slab_stiffness[of] @ pair.T
                )
                left_out = (vectors * np.maximum(values, 0.0)) @ vectors.T
                residual += 0.5 * np.einsum("ij,ab->iajb", left_out, sign)
        return seats, residual

    def wheels(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """W, R_pF and R_FF of wheelsets at ``x`` (w,), m in the window."""
        count = 6 * x.size
        W, R_FF = self._rows(x), self._between(x, x)
        for w, side in np.ndindex(x.size, 2):
            R_FF[w, side, :, w, side] += np.diag(self.sideways_residual)
        if self.held:
            W[:, :, [LATERAL, ROLL]] = R_FF[:, :, [LATERAL, ROLL]] = 0.0
        R_pF = self._between(self.x_p, x)
        return W.reshape(count, -1), R_pF.reshape(-1, count), R_FF.reshape(count, count)

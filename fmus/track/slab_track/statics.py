"""Static equilibrium of the window under given forces at the rail heads."""

from typing import NamedTuple

import numpy as np

from slab_track.assembly import LinearTrack


class StaticSolution(NamedTuple):
    """Equilibrium of one symmetry class.

    Attributes
    ----------
    rail, slab
        Modal coordinates, (2, N) and (S, n).
    fastener
        Forces in the fasteners, (P,), N, compression positive.
    residual
        Part of the fasteners' compression from the modes left out, (P,), m.
    deflection
        Of the rail under the loads, (w,), m.
    """

    rail: np.ndarray
    slab: np.ndarray
    fastener: np.ndarray
    residual: np.ndarray
    deflection: np.ndarray


def static_coordinates(
    track: LinearTrack, positions: np.ndarray, forces: np.ndarray, symmetry: int
) -> StaticSolution:
    """Solve the equilibrium of one symmetry class.

    ``positions`` (w,) in m from the window's start and ``forces`` (w,) in N are
    those of one symmetry class.
    """
    rail, slab = track.rail, track.slabs[symmetry]
    flexibility = 1.0 / rail.omega_squared
    beta = np.sum(rail.deflection**2 * flexibility, axis=0)
    wave = np.concatenate([rail.wave_number, track.residual_wave_number])
    compliance_of = np.concatenate([beta, track.residual_flexibility])
    fasteners = (np.arange(track.fastener_count) + 0.5) * track.length / track.fastener_count
    at_wheels = np.sin(np.outer(wave, positions))
    wheel_to_fastener = np.sin(np.outer(fasteners, wave)) @ (compliance_of[:, None] * at_wheels)
    matrix = track.fastener_admittance(flexibility, 1.0 / slab.omega_squared, symmetry)
    residual = track.fastener_residual(symmetry)
    matrix += residual
    matrix[np.diag_indices_from(matrix)] += 1.0 / track.stiffness
    fastener = np.linalg.solve(matrix, wheel_to_fastener @ forces)
    load = track.wave_shapes(positions) @ forces
    net = load - track.unfold(track.fastener_sines @ fastener)
    seat_forces = fastener.reshape(track.slab_count, track.seat_count)
    modes = slice(rail.wave_number.size, None)
    rail_residual = np.sin(np.outer(fasteners, wave[modes])) @ (
        compliance_of[modes, None] * at_wheels[modes]
    )
    deflection = (
        at_wheels.T @ (compliance_of * (at_wheels @ forces)) - wheel_to_fastener.T @ fastener
    )
    return StaticSolution(
        rail=flexibility * rail.deflection * net,
        slab=seat_forces @ slab.seats.T / slab.omega_squared,
        fastener=fastener,
        residual=rail_residual @ forces - residual @ fastener,
        deflection=deflection,
    )

"""Static equilibrium of the window under given forces at the rail heads."""

import numpy as np

from slab_track.assembly import LinearTrack


def static_coordinates(
    track: LinearTrack, positions: np.ndarray, forces: np.ndarray, symmetry: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return rail coordinates (2, N), slab coordinates (S, n) and fastener forces (P,).

    ``positions`` (w,) in m from the window's start and ``forces`` (w,) in N are
    those of one symmetry class.
    """
    rail, slab = track.rail, track.slabs[symmetry]
    flexibility = 1.0 / rail.omega_squared
    load = track.wave_shapes(positions) @ forces
    beta = np.sum(rail.deflection**2 * flexibility, axis=0)
    free = track.fastener_sines.T @ track.fold(beta * load)
    compliance = track.fastener_admittance(flexibility, 1.0 / slab.omega_squared, symmetry)
    compliance[np.diag_indices_from(compliance)] += 1.0 / track.stiffness
    fastener = np.linalg.solve(compliance, free)
    net = load - track.unfold(track.fastener_sines @ fastener)
    q_rail = flexibility * rail.deflection * net
    seat_forces = fastener.reshape(track.slab_count, track.seat_count)
    q_slab = seat_forces @ slab.seats.T / slab.omega_squared
    return q_rail, q_slab, fastener


def deflection(track: LinearTrack, q_rail: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Return the rail's deflection in m at positions in the window, shape (points,)."""
    amplitude = np.sum(track.rail.deflection * q_rail, axis=0)
    return track.wave_shapes(positions).T @ amplitude

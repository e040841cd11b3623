"""Finite line: two equal rails on slabs, split into motions alike and opposite on both sides.

In a linear track that is equal left and right, the half sum and the half difference of the two
sides do not interact. Each is one rail on half slabs: a `Line`.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg

from .beam import HALF_BANDWIDTH, BeamSection, assemble_hinged, shape_coefficients
from .kernel import local_compliance
from .parameters import ReferenceTrack
from .plate import HalfSlab, Symmetry, half_slab


@dataclass(frozen=True, kw_only=True)
class Line:
    """One rail on half slabs; dofs are the rail's nodes, then the slabs' modes in order."""

    track: ReferenceTrack
    section: BeamSection
    slab: HalfSlab
    slab_count: int
    rail_mass: np.ndarray
    rail_stiffness: np.ndarray

    @property
    def element_length(self) -> float:
        """Length of a rail element in m."""
        return self.track.fastener_spacing / self.track.rail_elements_per_bay

    @property
    def pad_dofs(self) -> np.ndarray:
        """Rail dofs at the fasteners (shape: pad)."""
        per_bay = self.track.rail_elements_per_bay
        pads = np.arange(self.slab_count * self.track.fastener_count_per_slab)
        return 2 * (pads * per_bay + per_bay // 2)

    @property
    def rail_dofs(self) -> int:
        """Number of rail dofs."""
        return self.rail_mass.shape[1]

    def locate(self, x: float) -> tuple[int, np.ndarray, float]:
        """First dof of the element at x, its deflection shapes there, and the local compliance."""
        h = self.element_length
        element = min(int(x / h), self.rail_dofs // 2 - 2)
        local = x - element * h
        shapes = local ** np.arange(4) @ shape_coefficients(self.section, h)
        flexibility = local_compliance(
            local, h, self.section.bending_stiffness, self.section.shear_stiffness
        )
        return 2 * element, shapes, flexibility

    def load_vectors(self, positions: np.ndarray) -> np.ndarray:
        """Give unit vertical loads on the rail (shape: dof, position)."""
        size = self.rail_dofs + self.slab_count * len(self.slab.stiffness)
        loads = np.zeros((size, len(positions)))
        for column, x in enumerate(positions):
            first, shapes, _ = self.locate(x)
            loads[first : first + 4, column] = shapes
        loads[[0, self.rail_dofs - 2]] = 0.0  # the hinges carry what falls on them
        return loads

    def local_compliances(self, positions: np.ndarray) -> np.ndarray:
        """Local compliance in m/N at each position."""
        return np.array([self.locate(x)[2] for x in positions])

    def matrices(self) -> tuple[sp.csc_array, sp.csc_array, sp.csc_array]:
        """Sparse mass, damping and stiffness of the line."""
        mass, stiffness = (
            sp.dia_array((_dia_layout(m), range(-HALF_BANDWIDTH, HALF_BANDWIDTH + 1)), (n, n))
            for m, n in ((self.rail_mass, self.rail_dofs), (self.rail_stiffness, self.rail_dofs))
        )
        modes = np.ones(self.slab_count)
        slab = [np.kron(modes, v) for v in (self.slab.damping, self.slab.stiffness)]
        pads = len(self.pad_dofs)
        rail_end = sp.csr_array(
            (np.ones(pads), (np.arange(pads), self.pad_dofs)), (pads, self.rail_dofs)
        )
        slab_end = sp.kron(sp.eye_array(self.slab_count), self.slab.seat_shape)
        stroke = sp.hstack([rail_end, -slab_end]).tocsr()
        coupling = stroke.T @ stroke
        rail_zero = sp.csc_array((self.rail_dofs, self.rail_dofs))
        slab_damping, slab_stiffness = (sp.diags_array(v) for v in slab)
        k, c = self.track.pad_stiffness, self.track.pad_damping
        return (
            sp.block_diag([mass, sp.eye_array(len(slab[0]))]).tocsc(),
            (sp.block_diag([rail_zero, slab_damping]) + c * coupling).tocsc(),
            (sp.block_diag([stiffness, slab_stiffness]) + k * coupling).tocsc(),
        )


def _dia_layout(diagonals: np.ndarray) -> np.ndarray:
    """Diagonals by row as in `assemble_hinged` -> by column as scipy keeps them."""
    return np.array([np.roll(row, d - HALF_BANDWIDTH) for d, row in enumerate(diagonals)])


_cached_slab = lru_cache(maxsize=16)(half_slab)


@lru_cache(maxsize=16)
def build_line(track: ReferenceTrack, slab_count: int, symmetry: Symmetry) -> Line:
    """Line of whole slabs, rail hinged at both ends."""
    section = BeamSection.of(track)
    elements = slab_count * track.fastener_count_per_slab * track.rail_elements_per_bay
    mass, stiffness = assemble_hinged(
        section, track.fastener_spacing / track.rail_elements_per_bay, elements
    )
    return Line(
        track=track,
        section=section,
        # The plate does not depend on these; a common key lets studies share it.
        slab=_cached_slab(
            replace(track, pad_stiffness=0.0, pad_damping=0.0, rail_elements_per_bay=2), symmetry
        ),
        slab_count=slab_count,
        rail_mass=mass,
        rail_stiffness=stiffness,
    )


def static_compliance(line: Line, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Solve for unit loads on the rail.

    Returns
    -------
    response : ndarray, shape (dof, position)
        Displacements in m/N, slab modes in m sqrt(kg)/N.
    compliance : ndarray, shape (position, position)
        Rail deflection under the loads in m/N, exact within the elements.
    """
    loads = line.load_vectors(positions)
    response = scipy.sparse.linalg.splu(line.matrices()[2]).solve(loads)
    return response, loads.T @ response + np.diag(line.local_compliances(positions))


def static_deflection(
    track: ReferenceTrack,
    load_positions: np.ndarray,
    loads: np.ndarray,
    positions: np.ndarray,
    *,
    slab_count: int = 16,
) -> np.ndarray:
    """Rail deflection in m at `positions` under equal loads (N) on both rails."""
    line = build_line(track, slab_count, "symmetric")
    response, _ = static_compliance(line, np.asarray(load_positions))
    deflection = line.load_vectors(np.asarray(positions)).T @ response
    same = np.isclose(np.subtract.outer(positions, load_positions), 0.0, atol=1e-12)
    return (deflection + same * line.local_compliances(np.asarray(load_positions))) @ loads


def receptance(
    track: ReferenceTrack,
    x: float,
    frequencies: np.ndarray,
    *,
    response_positions: np.ndarray | None = None,
    both_rails: bool = False,
    slab_count: int = 24,
) -> np.ndarray:
    """Harmonic deflection of the loaded rail per unit force, in m/N.

    Parameters
    ----------
    x : float
        Place of the force from the line's start in m; the middle keeps the ends out.
    frequencies : ndarray, shape (frequency,)
        Hz.
    response_positions : ndarray, shape (position,), optional
        Where the deflection is taken; default: under the force.
    both_rails : bool
        Force on both rails alike; otherwise on one rail alone.

    Returns
    -------
    ndarray, shape (frequency, position), complex
    """
    at = np.array([x]) if response_positions is None else np.asarray(response_positions)
    families: tuple[Symmetry, ...] = ("symmetric", "antisymmetric")
    lines = [build_line(track, slab_count, f) for f in (families[:1] if both_rails else families)]
    total = np.zeros((len(frequencies), len(at)), complex)
    for line in lines:
        mass, damping, stiffness = line.matrices()
        load, probe = line.load_vectors(np.array([x]))[:, 0], line.load_vectors(at)
        local = np.isclose(at, x, atol=1e-12) * line.locate(x)[2]
        for row, omega in enumerate(2 * np.pi * np.asarray(frequencies)):
            dynamic = (stiffness + 1j * omega * damping - omega**2 * mass).tocsc()
            total[row] += probe.T @ scipy.sparse.linalg.spsolve(dynamic, load) + local
    return total / len(lines)

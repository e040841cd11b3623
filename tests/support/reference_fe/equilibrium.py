"""Static equilibrium, from which a run starts, and the system's energy."""

import numpy as np

from .containers import State
from .line import Line, static_compliance
from .operators import FAMILY_SIGN
from .rolling_stock import RollingStock


def static_equilibrium(
    lines: list[Line], stock: RollingStock, positions: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vehicle at rest on the track, by Newton's method on vehicle dofs and penetrations.

    Returns
    -------
    body, force, penetration : ndarray
        Vehicle dofs; wheel forces in N and Hertzian approaches in m, per contact.
    """
    sides = len(lines)
    compliance = np.zeros((len(stock.contact), len(stock.contact)))
    for f, line in enumerate(lines):
        _, direct = static_compliance(line, positions)
        sign = FAMILY_SIGN[:sides, f]
        compliance += np.kron(direct, np.outer(sign, sign)) / sides
    count, dofs = len(compliance), len(stock.mass)
    body = np.zeros(dofs)
    penetration = np.full(count, 1e-4)
    for _ in range(50):
        force = (np.maximum(penetration, 0) / stock.hertz_constant) ** 1.5
        slope = 1.5 * np.sqrt(np.maximum(penetration, 0)) / stock.hertz_constant**1.5
        pressed = stock.multiplicity * stock.contact.T
        residual = np.concatenate(
            [
                stock.load - stock.stiffness @ body - pressed @ force,
                stock.contact @ body - compliance @ force - penetration,
            ]
        )
        jacobian = np.block(
            [
                [stock.stiffness, pressed * slope],
                [-stock.contact, np.eye(count) + compliance * slope],
            ]
        )
        change = np.linalg.solve(jacobian, residual)
        body, penetration = body + change[:dofs], penetration + change[dofs:]
        if np.abs(change[dofs:]).max() < 1e-15:
            break
    return body, force, penetration


def static_start(lines: list[Line], stock: RollingStock, positions: np.ndarray) -> State:
    """State of a vehicle at rest on the track."""
    body, force, penetration = static_equilibrium(lines, stock, positions)
    line, sides = lines[0], len(lines)
    modes = line.slab.seat_shape.shape[1]
    state = State(
        rail=np.zeros((3, sides, line.rail_dofs)),
        rail_force=np.zeros((sides, line.rail_dofs)),
        slab=np.zeros((3, sides, line.slab_count, modes)),
        slab_force=np.zeros((sides, line.slab_count, modes)),
        body=np.zeros((3, len(body))),
        force=force,
        penetration=penetration,
    )
    state.body[0] = body
    for f, half in enumerate(lines):
        share = force.reshape(-1, sides) @ FAMILY_SIGN[:sides, f] / sides
        response = static_compliance(half, positions)[0] @ share
        state.rail[0, f] = response[: line.rail_dofs]
        state.slab[0, f] = response[line.rail_dofs :].reshape(half.slab_count, modes)
        # At rest nodal forces balance the elastic ones.
        state.slab_force[f] = half.slab.stiffness * state.slab[0, f]
        seats = (state.slab[0, f] @ half.slab.seat_shape.T).ravel()
        load = half.load_vectors(positions)[: line.rail_dofs] @ share
        load[line.pad_dofs] -= half.track.pad_stiffness * (state.rail[0, f, line.pad_dofs] - seats)
        state.rail_force[f] = load
    return state


def total_energy(
    lines: list[Line], stock: RollingStock, state: State, positions: np.ndarray
) -> float:
    """Kinetic and potential energy of track, contacts and vehicle (with its weight) in J."""
    sides = len(lines)
    energy = 0.0
    for f, line in enumerate(lines):
        mass, _, stiffness = line.matrices()
        u, v = (np.concatenate([state.rail[i, f], state.slab[i, f].ravel()]) for i in (0, 1))
        energy += 0.5 * sides * (u @ (stiffness @ u) + v @ (mass @ v))
    local = np.repeat(lines[0].local_compliances(positions), sides)
    energy += (0.4 * state.force * np.maximum(state.penetration, 0.0)).sum()
    energy += (0.5 * local * state.force**2).sum()
    z, rate = state.body[0], state.body[1]
    own = 0.5 * (z @ stock.stiffness @ z + rate @ stock.mass @ rate) - stock.load @ z
    return float(stock.multiplicity * energy + own)

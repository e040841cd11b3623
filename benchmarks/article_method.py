"""The article's method, written plainly in numpy: what the product's speed is compared with.

Vertical motion only, as in the article: a vehicle of 10 degrees of freedom, two rails of 200
Timoshenko modes, eqs. (6a), (6b), 13 slabs of 24 plate modes, Hertzian contact, eq. (1), the window
moved by least squares with M = 250, eqs. (8) to (11), and the explicit two-step method of Zhai
with steps of 5 us, near the limit of stability of the shear modes. Slab shapes are products
of free-beam functions along and straight lines across the slab. The values are those of Table 2, as
the line and the vehicle ``paper`` of the product have them.

``python benchmarks/article_method.py`` prints the CPU time per slab length as JSON.
"""

import json
import time

import numpy as np

SPEED, STEP = 300.0 / 3.6, 5e-6
BAY, BAYS, SLABS = 0.629, 8, 13
PITCH, LENGTH = BAY * BAYS, BAY * BAYS * SLABS
WHEELSETS = np.array([0.0, 2.5, 17.8, 20.3])  # behind the leading one
FOREMOST = 0.5 * (LENGTH + PITCH + WHEELSETS[-1])  # the vehicle keeps to the window's middle
MODES, SAMPLES = 200, 250
E, G, RHO, AREA, INERTIA, KAPPA = 2.059e11, 7.9e10, 7860.0, 7.745e-3, 3.217e-5, 0.5329
PAD, PAD_DAMPING = 40e6, 52e3
SLAB_LENGTH, SLAB_WIDTH, SLAB_THICKNESS, SLAB_DENSITY, SLAB_E = 4.962, 2.5, 0.17, 2800.0, 3.6e10
LAYER, LAYER_DAMPING = 5000e6 / (BAY * SLAB_WIDTH), 300e3 / (BAY * SLAB_WIDTH)
RADIUS, GAUGE = 0.46, 1.493  # of the rolling circles
CAR_BODY_MASS, CAR_BODY_PITCH_INERTIA = 44039.0, 1.69e6
BOGIE_MASS, BOGIE_PITCH_INERTIA, WHEELSET_MASS = 2439.0, 1846.0, 1881.0
SECONDARY, SECONDARY_DAMPING = 0.24e6, 25e3
PRIMARY, PRIMARY_DAMPING = 9e6, 10.5e3
HALF_BOGIE_SPACING, HALF_WHEELBASE = 8.9, 1.25
HERTZ = 3.86e-8 * RADIUS**-0.115
GRAVITY = 9.81


class Track:
    """Two rails, 104 fasteners each, slabs: modal accelerations from displacements and rates."""

    def __init__(self):
        k = np.pi * np.arange(1, MODES + 1) / LENGTH
        mass, turn, shear = RHO * AREA, RHO * INERTIA, KAPPA * G * AREA
        self.k, self.scale = k, np.sqrt(2.0 / (mass * LENGTH))
        self.k11 = shear * k**2 / mass
        self.k22 = (shear + E * INERTIA * k**2) / turn
        self.k12 = -shear * k / np.sqrt(mass * turn)
        x = (np.arange(BAYS * SLABS) + 0.5) * BAY
        self.at_fasteners = self.scale * np.sin(np.outer(k, x))
        self._slab_shapes()
        points = (np.arange(SAMPLES) + 0.5) * LENGTH / SAMPLES
        inside = (points + PITCH <= LENGTH)[:, None]
        self.move = [
            np.linalg.lstsq(
                shape(np.outer(points, k)),
                np.where(inside, shape(np.outer(points + PITCH, k)), 0.0),
                rcond=None,
            )[0]
            for shape in (np.sin, np.cos)
        ]

    def _slab_shapes(self):
        length, width, area_mass = SLAB_LENGTH, SLAB_WIDTH, SLAB_DENSITY * SLAB_THICKNESS
        mass = area_mass * length * width
        x = (np.arange(BAYS) + 0.5) * BAY - 0.5 * PITCH
        roots = np.array([4.730041, 7.853205, 10.995608, *(np.arange(4, 11) + 0.5) * np.pi])
        s = x / length + 0.5
        along = [np.ones(BAYS), np.sqrt(3.0) * 2.0 * x / length]
        for b in roots:
            sigma = (np.cosh(b) - np.cos(b)) / (np.sinh(b) - np.sin(b))
            value = np.cosh(b * s) + np.cos(b * s) - sigma * (np.sinh(b * s) + np.sin(b * s))
            along.append(value)
        bending = SLAB_E * SLAB_THICKNESS**3 / 12.0 / area_mass
        frequency = np.concatenate([[0.0, 0.0], bending * (roots / length) ** 4])
        across = np.sqrt(12.0) * np.array([-0.5, 0.5]) * GAUGE / width
        shapes = [np.outer(a, [1.0, 1.0]) for a in along] + [np.outer(a, across) for a in along]
        self.seats = np.array(shapes).reshape(24, BAYS, 2) / np.sqrt(mass)
        self.slab_k = np.concatenate([frequency, frequency]) + LAYER / area_mass
        self.slab_c = LAYER_DAMPING / area_mass

    def accelerations(self, state, rate, at_wheels, force):
        """Accelerations of (rails (2, 2, N), slabs (S, 24)) under wheel forces (2, 4)."""
        (rails, slabs), (rail_rates, slab_rates) = state, rate
        rail = rails[:, 0] @ self.at_fasteners
        rail_v = rail_rates[:, 0] @ self.at_fasteners
        seat = np.einsum("sn,nbr->rsb", slabs, self.seats).reshape(2, -1)
        seat_v = np.einsum("sn,nbr->rsb", slab_rates, self.seats).reshape(2, -1)
        pads = PAD * (rail - seat) + PAD_DAMPING * (rail_v - seat_v)
        load = force @ at_wheels.T - pads @ self.at_fasteners.T
        q, w = rails[:, 0], rails[:, 1]
        rail_a = np.stack(
            [load - self.k11 * q - self.k12 * w, -self.k12 * q - self.k22 * w], axis=1
        )
        on_slabs = np.einsum("rsb,nbr->sn", pads.reshape(2, SLABS, BAYS), self.seats)
        return rail_a, on_slabs - self.slab_k * slabs - self.slab_c * slab_rates

    def rest(self, at_wheels, force):
        """Return the static deflection of (rails, slabs) under wheel forces."""
        shapes = (2, 2, MODES), (SLABS, 24)
        zero = [np.zeros(shape) for shape in shapes]

        def accelerations(vector, force):
            parts = np.split(vector, [4 * MODES])
            state = [part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)]
            found = self.accelerations(state, zero, at_wheels, force)
            return np.concatenate([part.ravel() for part in found])

        units = np.eye(4 * MODES + 24 * SLABS)
        stiffness = np.array([accelerations(unit, np.zeros_like(force)) for unit in units]).T
        found = np.linalg.solve(stiffness, -accelerations(np.zeros(len(units)), force))
        parts = np.split(found, [4 * MODES])
        return [part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)]

    def slide(self, rails, slabs):
        """Move rails and slabs back by one pitch."""
        moved = np.zeros_like(slabs)
        moved[:-1] = slabs[1:]
        return np.stack([rails[:, 0] @ self.move[0].T, rails[:, 1] @ self.move[1].T], axis=1), moved


def vehicle_matrices():
    """Mass, stiffness, damping of car body, two frames (bounce, pitch), four wheelsets."""
    bogie = [BOGIE_MASS, BOGIE_PITCH_INERTIA]
    mass = np.array([CAR_BODY_MASS, CAR_BODY_PITCH_INERTIA, *bogie * 2, *[WHEELSET_MASS] * 4])
    k, c = np.zeros((10, 10)), np.zeros((10, 10))

    def link(row, stiffness, damping):
        k[:] += stiffness * np.outer(row, row)
        c[:] += damping * np.outer(row, row)

    for bogie, place in ((0, HALF_BOGIE_SPACING), (1, -HALF_BOGIE_SPACING)):
        row = np.zeros(10)
        row[0], row[1], row[2 + 2 * bogie] = 1.0, -place, -1.0
        link(row, 2 * SECONDARY, 2 * SECONDARY_DAMPING)
        for wheel, arm in ((0, HALF_WHEELBASE), (1, -HALF_WHEELBASE)):
            row = np.zeros(10)
            row[2 + 2 * bogie], row[3 + 2 * bogie], row[6 + 2 * bogie + wheel] = 1.0, -arm, -1.0
            link(row, 2 * PRIMARY, 2 * PRIMARY_DAMPING)
    return mass, k, c


def run(distance):
    """Run over ``distance`` m; return wheel forces (steps, 2, 4) in N and the steps' CPU time, s.

    The leading wheelset starts between two slabs, and all in static equilibrium.
    """
    track, (mass, k, c) = Track(), vehicle_matrices()
    load = np.zeros(10)
    load[6:] = np.sum(mass[[0, 2, 4, 6, 7, 8, 9]]) * GRAVITY / 4.0
    static = load[6] / 2.0
    x, found = 9 * PITCH - WHEELSETS, []
    at_wheels = track.scale * np.sin(np.outer(track.k, x))
    rails, slabs = track.rest(at_wheels, np.full((2, 4), static))
    wheelsets = HERTZ * static ** (2.0 / 3.0) + (rails[:, 0] @ at_wheels).mean(axis=0)
    bodies = np.linalg.solve(k[:6, :6], -k[:6, 6:] @ wheelsets)
    fields = [rails, slabs, np.concatenate([bodies, wheelsets])]
    rates, accelerations = [np.zeros_like(f) for f in fields], [np.zeros_like(f) for f in fields]
    before = [a.copy() for a in accelerations]
    begin = time.process_time()
    for _ in range(round(distance / (SPEED * STEP))):
        # Zhai's two-step method, psi = phi = 1/2.
        for f, v, a, b in zip(fields, rates, accelerations, before, strict=True):
            f += v * STEP + (1.0 * a - 0.5 * b) * STEP**2
            v += (1.5 * a - 0.5 * b) * STEP
        x = x + SPEED * STEP
        if x[0] > FOREMOST:
            x = x - PITCH
            for group in (fields, rates, accelerations, before):
                group[0], group[1] = track.slide(group[0], group[1])
        at_wheels = track.scale * np.sin(np.outer(track.k, x))
        depth = fields[2][6:] - fields[0][:, 0] @ at_wheels
        force = (np.maximum(depth, 0.0) / HERTZ) ** 1.5
        before = accelerations
        rail_a, slab_a = track.accelerations(fields[:2], rates[:2], at_wheels, force)
        reaction = load.copy()
        reaction[6:] -= force.sum(axis=0)
        vehicle_a = (reaction - k @ fields[2] - c @ rates[2]) / mass
        accelerations = [rail_a, slab_a, vehicle_a]
        found.append(force)
    return np.array(found), time.process_time() - begin


def main() -> None:
    """Print the CPU time per slab length."""
    run(0.1)
    force, seconds = run(PITCH)
    assert np.all(np.isfinite(force))
    assert 3e4 < force[-100:].mean() < 1.2e5
    print(json.dumps({"seconds_per_slab_length": seconds, "steps": len(force)}))


if __name__ == "__main__":
    main()

"""The track FMU without a vehicle: loads of one's own on the rail heads, against closed forms.

With ``interface = applied_force`` the track takes forces at the rail heads and gives the rails'
motion back, so a tool can use it with a contact model of its own. Here fasteners lie close on slabs
that hardly move, so that the rail is a Timoshenko beam on a viscoelastic foundation, for which
Fourier integrals over the wave number are known.
"""

import sys
from pathlib import Path

import fmpy
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad

FORCE = 10e3  # N on each rail
SPACING = 0.2  # m, short against the wavelengths of the rail on its foundation
PAD_STIFFNESS, PAD_DAMPING = 8e6, 10e3  # N/m and N.s/m of each fastener
RAIL = {
    "rail.youngs_modulus": 2.059e11,
    "rail.shear_modulus": 7.9e10,
    "rail.density": 7860.0,
    "rail.area": 7.745e-3,
    "rail.vertical_second_moment": 3.217e-5,
    "rail.vertical_shear_coefficient": 0.5329,
}
PARAMETERS = {
    **RAIL,
    "interface": "applied_force",
    "contact.model": "vertical",
    "wheelset_count": 1,
    "static_wheel_load": 0.0,
    "fastener.spacing": SPACING,
    "fastener.vertical_stiffness": PAD_STIFFNESS,
    "fastener.vertical_damping": PAD_DAMPING,
    "slab.youngs_modulus": 1e14,
    "slab_support.vertical_stiffness": 1e13,
    "window.slab_count": 24,
    "rail.mode_count": 300,
}
DEFLECTION = "wheelset[1].left.rail_vertical_displacement"


def _admittance(wave_number: float, s: complex) -> complex:
    """Return deflection per force per length of a wave ``exp(i k x + s t)``, m2/N."""
    e, g, rho, area, second, kappa = RAIL.values()
    shear = kappa * g * area
    k = wave_number
    foundation = (PAD_STIFFNESS + s * PAD_DAMPING) / SPACING + rho * area * s * s
    bending = e * second * k * k + shear + rho * second * s * s
    return 1.0 / (foundation + shear * k * k - (shear * k) ** 2 / bending)


def moving_deflection(speed: float) -> float:
    """Deflection under a constant force that moves along, m: steady, seen from the force."""

    def share(k: float) -> float:
        return (_admittance(k, -1j * k * speed) + _admittance(-k, 1j * k * speed)).real

    return FORCE / (2.0 * np.pi) * quad(share, 0.0, np.inf, limit=500)[0]


def harmonic_deflection(frequency: float) -> complex:
    """Complex amplitude under a force ``FORCE exp(i omega t)`` that stands still, m."""
    s = 2j * np.pi * frequency
    parts = [
        quad(lambda k, f=f: f(_admittance(k, s)), 0.0, np.inf, limit=500)[0]
        for f in (np.real, np.imag)
    ]
    return FORCE / np.pi * complex(*parts)


def simulate(
    fmu: Path, time: NDArray, position: NDArray, force: NDArray, step: float
) -> NDArray[np.float64]:
    """Run the track with these inputs, (steps,); return the deflection at each, m."""
    names = ["wheelset[1].longitudinal_position", "wheelset[1].longitudinal_velocity"]
    heads = [f"rail_head[1].{side}.vertical_force" for side in ("left", "right")]
    table = np.zeros(len(time), dtype=[(name, float) for name in ["time", *names, *heads]])
    table["time"], table[names[0]] = time, position
    table[names[1]] = np.gradient(position, time)
    for head in heads:
        table[head] = force
    result = fmpy.simulate_fmu(
        str(fmu),
        start_values=PARAMETERS,
        input=table,
        output=[DEFLECTION],
        output_interval=step,
        stop_time=time[-1] - step,
    )
    return result[DEFLECTION]


def moving_load(fmu: Path, speed: float = 60.0) -> tuple[float, float]:
    """Deflection under a moving constant force, m: computed, and in closed form."""
    step = SPACING / speed / 40
    time = step * np.arange(4000)
    found = simulate(fmu, time, 0.3 + speed * time, np.full(time.size, FORCE), step)
    return float(found[-800:].mean()), moving_deflection(speed)


def harmonic_load(fmu: Path, frequency: float = 200.0) -> tuple[complex, complex]:
    """Complex amplitude under a harmonic force at a fastener, m: computed, and in closed form."""
    step = 1.0 / frequency / 80
    time = step * np.arange(80 * 30)
    turn = np.exp(2j * np.pi * frequency * time)
    # A force counts for the end of the step that it is given for.
    force = FORCE * (turn * turn[1]).real
    found = simulate(fmu, time, np.full(time.size, 8.5 * SPACING), force, step)
    last = slice(len(found) - 400, len(found))  # five periods
    amplitude = 2.0 * np.mean(found[last] / turn[last])
    return complex(amplitude), harmonic_deflection(frequency)


if __name__ == "__main__":
    path = Path(sys.argv[1])
    for name, load in (("moving", moving_load), ("harmonic", harmonic_load)):
        computed, expected = load(path)
        print(f"{name} load: {computed:.6g} m, in closed form {expected:.6g} m")

"""Co-simulation algorithms: one per file, chosen by name."""

from __future__ import annotations

from rail_cosim.algorithms.base import STEP_END, STEP_START, Algorithm
from rail_cosim.algorithms.gauss_seidel import GaussSeidel
from rail_cosim.algorithms.iterative import IterativeGaussSeidel
from rail_cosim.algorithms.jacobi import Jacobi
from rail_cosim.errors import UnknownNameError

ALGORITHMS = {kind.name: kind for kind in (GaussSeidel, Jacobi, IterativeGaussSeidel)}


def make_algorithm(name: str) -> Algorithm:
    """Return a new algorithm by its name.

    Raises
    ------
    UnknownNameError
        If there is none of this name.
    """
    if name not in ALGORITHMS:
        raise UnknownNameError("--algorithm", name, ALGORITHMS, "algorithm", wanted=name)
    return ALGORITHMS[name]()


__all__ = [
    "ALGORITHMS",
    "STEP_END",
    "STEP_START",
    "Algorithm",
    "GaussSeidel",
    "IterativeGaussSeidel",
    "Jacobi",
    "make_algorithm",
]

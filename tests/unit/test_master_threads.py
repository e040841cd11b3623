"""One thread for linear algebra while FMUs run in this process, and as many as before after it."""

import os
import subprocess
import sys

PROGRAM = """
import numpy, scipy.linalg, threadpoolctl
from rail_cosim.threads import one_thread

def threads():
    return {found["num_threads"] for found in threadpoolctl.threadpool_info()}

before = threads()
with one_thread():
    inside = threads()
assert inside == {1}, inside
assert threads() == before, (threads(), before)
"""
TWO_THREADS = os.environ | {"OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2"}


def _run(program):
    command = [sys.executable, "-c", program]
    return subprocess.run(command, capture_output=True, text=True, env=TWO_THREADS)


def test_there_is_one_thread_inside():
    done = _run(PROGRAM)
    assert done.returncode == 0, done.stderr


def test_a_run_and_the_benchmark_have_one_thread(fmus, monkeypatch):
    import threadpoolctl
    from rail_cosim import simulation
    from rail_cosim.runner import run

    seen = []
    steps = simulation.Simulation.run

    def look(self, *arguments, **keywords):
        seen.append({found["num_threads"] for found in threadpoolctl.threadpool_info()})
        return steps(self, *arguments, **keywords)

    monkeypatch.setattr(simulation.Simulation, "run", look)
    run(track=fmus.track, vehicle=fmus.vehicle, speed=83.0, distance=0.1)
    assert seen
    assert all(threads == {1} for threads in seen)


def test_the_slide_starts_no_thread():
    """Its products stay below the size from which OpenBLAS divides them."""
    program = f"""
import os, sys
sys.path[:0] = {sys.path!r}
import numpy as np, time
from slab_track.slide import ByMatrix
matrix, fields = np.random.rand(315, 315), np.random.rand(18, 315)
slide = ByMatrix(matrix)
slide(fields)
wall, work = time.perf_counter(), time.process_time()
for _ in range(200):
    slide(fields)
wall, work = time.perf_counter() - wall, time.process_time() - work
assert work < 1.2 * wall, (work, wall)
assert np.allclose(slide(fields), fields @ matrix.T, rtol=1e-12, atol=1e-12)
"""
    done = _run(program)
    assert done.returncode == 0, done.stderr

"""One thread for linear algebra while FMUs run in this process, and as many as before after it."""

import subprocess
import sys
from pathlib import Path

PROGRAM = """
import threadpoolctl
from rail_cosim.threads import one_thread

def threads():
    return {found["num_threads"] for found in threadpoolctl.threadpool_info()}

threadpoolctl.threadpool_limits(2)
with one_thread():
    inside = threads()
    import scipy.linalg
    assert threads() == inside == {1}, (inside, threads())
assert threads() - {1} or not inside, threads()
"""


def test_there_is_one_thread_inside():
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True)
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
    source = Path(__file__).parents[2] / "fmus/track/slab_track/slide.py"
    program = f"""
import os, sys
sys.path[:0] = {sys.path!r}
import numpy as np, threadpoolctl, time
from slab_track.slide import _moved
assert {source.name!r} == "slide.py"
threadpoolctl.threadpool_limits(2)
matrix, fields = np.random.rand(315, 315), [np.random.rand(6, 3, 315), np.random.rand(12, 315)]
_moved(matrix, fields)
wanted = [field @ matrix.T for field in fields]
for found, right in zip(_moved(matrix, fields), wanted):
    assert np.allclose(found, right, rtol=1e-12, atol=1e-12)
wall, work = time.perf_counter(), time.process_time()
for _ in range(200):
    _moved(matrix, fields)
wall, work = time.perf_counter() - wall, time.process_time() - work
assert work < 1.2 * wall, (work, wall)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr

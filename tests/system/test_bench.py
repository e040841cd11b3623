"""rail-cosim bench: figures that add up, and the article's method beside them."""

import json
from pathlib import Path

import pytest
from product import Product

REFERENCE = Path(__file__).parents[2] / "benchmarks" / "article_method.py"


def test_bench_tells_where_the_time_goes_and_compares(fmus: Product):
    found = json.loads(fmus.command("bench", "--json", "--reference", REFERENCE).stdout)
    parts = found["microseconds_per_step"]
    steps = 604
    assert parts["total"] == pytest.approx(1e6 * found["seconds_per_slab_length"] / steps, rel=1e-3)
    assert found["real_time_factor"] == pytest.approx(
        steps * found["macro_step"] / found["seconds_per_slab_length"], rel=1e-9
    )
    assert found["ratio"] > 10.0  # 27 to 35 where it was measured; CPU times, whatever else runs
    assert 0.0 < parts["vehicle"] < parts["track"] < 1.5 * parts["total"]
    assert found["setup"] > 0.0
    inside = found["track_microseconds_per_step"]
    assert sum(inside[name] for name in ("rails", "contact", "slide")) == pytest.approx(
        inside["total"], rel=0.02
    )
    assert found["slide_share"] == pytest.approx(inside["slide"] / parts["total"], rel=1e-3)
    assert 0.0 < found["slide_share"] < 0.02  # goal: 0.005; the article's is 0.021


def test_bench_refuses_a_reference_that_is_not_there(fmus: Product, tmp_path):
    done = fmus.command("bench", "--reference", tmp_path / "nothing.py", status=(2,))
    assert "--reference" in done.stderr
    assert "nothing.py" in done.stderr

"""Arrays kept on disk: the same again, made anew when anything differs, never fatal."""

import numpy as np
import pytest
from rail_quantities import kept_array


@pytest.fixture
def maker(tmp_path, monkeypatch):
    """Return a function that asks for an array, and the list of what was made."""
    monkeypatch.setenv("RAIL_COSIM_CACHE", str(tmp_path / "cache"))
    code, made = tmp_path / "package", []
    code.mkdir()
    (code / "module.py").write_text("a = 1")

    def ask(key):
        def make():
            made.append(key)
            return np.arange(3.0) / 7.0 + hash(key)

        return kept_array("kind", key, make, code)

    return ask, made


def test_the_second_time_it_is_read_bit_by_bit(maker):
    ask, made = maker
    first, second = ask((1, "a", 0.1)), ask((1, "a", 0.1))
    assert made == [(1, "a", 0.1)]
    assert first.tobytes() == second.tobytes()


def test_another_key_is_another_array(maker):
    ask, made = maker
    ask((0.1,))
    ask((np.nextafter(0.1, 1.0).item(),))
    assert len(made) == 2


def test_a_damaged_file_is_made_anew(maker, tmp_path):
    ask, made = maker
    ask(1)
    (file,) = (tmp_path / "cache").rglob("*.npy")
    file.write_bytes(file.read_bytes()[:50])
    np.testing.assert_array_equal(ask(1), np.arange(3.0) / 7.0 + 1)
    assert made == [1, 1]
    ask(1)
    assert made == [1, 1]


def test_a_changed_number_is_found_by_the_checksum(maker, tmp_path):
    ask, made = maker
    first = ask((1,))
    (file,) = (tmp_path / "cache" / "arrays" / "kind").glob("*.npy")
    content = bytearray(file.read_bytes())
    content[-40] ^= 1  # in the last number
    file.write_bytes(content)
    assert ask((1,)).tobytes() == first.tobytes()
    assert len(made) == 2


def test_without_a_cache_it_is_made_each_time(maker, tmp_path):
    ask, made = maker
    (tmp_path / "cache").write_text("a file where the folder should be")
    ask(1)
    ask(1)
    assert made == [1, 1]


def test_the_cache_does_not_grow_for_ever(maker, tmp_path):
    ask, _ = maker
    for key in range(60):
        ask(key)
    assert len(list((tmp_path / "cache").rglob("*.npy"))) == 40

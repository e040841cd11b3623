"""The transforms of the window's shift against scipy's."""

import numpy as np
import pytest
import scipy.fft
from slab_track.kernels.transforms import make_transform, samples_to_waves, waves_to_samples


@pytest.mark.parametrize("length", [1, 2, 3, 4, 5, 8, 12, 21, 49, 384])
@pytest.mark.parametrize("cosines", [False, True])
def test_transforms_are_those_of_scipy(length, cosines):
    rows = np.random.default_rng(length).normal(size=(6, length))
    transform, of = make_transform(length, 6), scipy.fft.dct if cosines else scipy.fft.dst
    for kind, replace in ((3, waves_to_samples), (2, samples_to_waves)):
        found = rows.copy()
        replace(transform, cosines, found)
        np.testing.assert_allclose(found, of(rows, type=kind, axis=1), rtol=0, atol=1e-12)

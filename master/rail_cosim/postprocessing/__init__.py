"""Evaluation of runs: filters, statistics, spectra, orders and comfort, on the Dataset of a run.

>>> import xarray as xr                                          # doctest: +SKIP
>>> from rail_cosim import postprocessing as post
>>> run = xr.open_dataset("run.nc", engine="h5netcdf")           # doctest: +SKIP
>>> post.wheel_statistics(run)["unloading"]                      # doctest: +SKIP
>>> post.third_octaves(run.axle_box_vertical_acceleration)       # doctest: +SKIP

Functions of one signal take a DataArray with the dimension ``time`` and any others; what needs
the distance or the parameters takes the Dataset, too. All keep units and coordinates. What they
mean, with formulas and standards, is in ``docs/postprocessing.md``.
"""

from rail_cosim.postprocessing.comfort import (
    comfort_in_words,
    continuous_comfort,
    mean_comfort,
    sperling_index,
    sperling_of_sine,
    weighted_rms,
)
from rail_cosim.postprocessing.filters import band_pass, low_pass, moving_mean, percentiles
from rail_cosim.postprocessing.orders import (
    order_spectrum,
    over_distance,
    passing_amplitudes,
    passing_frequencies,
)
from rail_cosim.postprocessing.spectra import (
    amplitude_spectrum,
    levels,
    nominal_frequencies,
    power_spectral_density,
    spectrogram,
    third_octave_bands,
    third_octaves,
)
from rail_cosim.postprocessing.statistics import (
    basic_statistics,
    evaluated,
    flange_climbing,
    guiding_statistics,
    static_wheel_load,
    steady_state_amplitude,
    sum_of_guiding_forces,
    vertical_force,
    wheel_statistics,
)
from rail_cosim.postprocessing.weighting import weighted, weighting

__all__ = [
    "amplitude_spectrum",
    "band_pass",
    "basic_statistics",
    "comfort_in_words",
    "continuous_comfort",
    "evaluated",
    "flange_climbing",
    "guiding_statistics",
    "levels",
    "low_pass",
    "mean_comfort",
    "moving_mean",
    "nominal_frequencies",
    "order_spectrum",
    "over_distance",
    "passing_amplitudes",
    "passing_frequencies",
    "percentiles",
    "power_spectral_density",
    "spectrogram",
    "sperling_index",
    "sperling_of_sine",
    "static_wheel_load",
    "steady_state_amplitude",
    "sum_of_guiding_forces",
    "third_octave_bands",
    "third_octaves",
    "vertical_force",
    "weighted",
    "weighted_rms",
    "weighting",
    "wheel_statistics",
]

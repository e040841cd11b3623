"""The loop over macro steps, in C."""

from rail_native import CLibrary

core = CLibrary("rail_cosim", "loop.c")

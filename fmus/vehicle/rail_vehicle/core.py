"""The compiled core of the vehicle."""

from rail_native import Core

core = Core("rail_vehicle", modules=("kernels",))

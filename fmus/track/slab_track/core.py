"""The compiled core of the track."""

from rail_native import Core

core = Core(
    "slab_track",
    modules=(
        "contact.creepage",
        "contact.fastsim",
        "contact.interaction",
        "contact.overlap",
        "contact.solve",
        "contact.tables",
        "contact.wheelset",
        "irregularity.geometry",
        "irregularity.kernels",
        "irregularity.noise",
        "kernels.arrays",
        "kernels.distance",
        "kernels.lateral",
        "kernels.motion",
        "kernels.shift",
        "kernels.state",
        "kernels.step",
        "kernels.transforms",
        "kernels.vertical",
        "kernels.waves",
    ),
)

"""Named lines: Harbin-Dalian (HD) and Zhengzhou-Xuzhou (ZX), Table 2 of the article.

``paper`` is the HD line with the article's numerical settings: 13 slabs, 200 plain rail modes,
least squares over 250 samples, hinged ends without added damping, and of its 30 slab modes the 24
that carry vertical load: 3 rigid ones and 21 of plate bending below 450 Hz.
"""

from slab_track.parameters import Fastener, Rail, Slab, TrackParameters, Window

HD = TrackParameters()
ZX = TrackParameters(
    fastener=Fastener(spacing=0.63, count_per_slab=9),
    slab=Slab(thickness=0.2),
    window=Window(slab_count=14),
)

PAPER = TrackParameters(
    rail=Rail(mode_count=200, residual_compliance=False),
    slab=Slab(mode_count=24, residual_compliance=False),
    window=Window(slab_count=13, vehicle_offset=0.0, sample_count=250, end_damping=0.0),
)

LINES = {"HD": HD, "ZX": ZX, "paper": PAPER}

"""Named lines: Harbin-Dalian (HD) and Zhengzhou-Xuzhou (ZX), Table 2 of the article."""

from slab_track.parameters import Fastener, Slab, TrackParameters

HD = TrackParameters()
ZX = TrackParameters(
    fastener=Fastener(spacing=0.63, count_per_slab=9),
    slab=Slab(thickness=0.2),
)

LINES = {"HD": HD, "ZX": ZX}

"""Options of a valve that measurements may or may not justify: one more is one entry."""

from typing import Final

from ehamj.identification.option import ValveOption
from ehamj.registry import Registry

OPTIONS: Final[Registry[ValveOption]] = Registry("option")
"""By the name that ``[choice] options`` has."""

_SLOWLY: Final = "a valve test whose commands turn back often and far beyond it, as a multisine does"

OPTIONS.add(
    "hysteresis",
    ValveOption("a hysteresis", "hysteresis", (0.001, 0.004, 0.016), (0.0, 0.1), 0.002, _SLOWLY, of_stroke=True),
)
OPTIONS.add(
    "overlap",
    ValveOption(
        "an overlap of the edges (negative: underlap)", "overlap", (0.002, 0.008, 0.03, -0.004), (-0.05, 0.1), 0.005,
        "a valve test that crosses null often, at amplitudes of some times the overlap", of_stroke=True,
    ),
)  # fmt: skip
OPTIONS.add(
    "air",
    ValveOption(
        "air in the oil", "air_fraction", (0.001, 0.004, 0.016), (0.0, 0.1), 0.002,
        "a leak-down (fault 'supply-lost'): at the supply's pressures air hardly differs from softer oil, at low "
        "ones it is the softer part",
    ),
)  # fmt: skip
OPTIONS.add(
    "null-offset",
    ValveOption(
        "an offset of the null", "null_offset", (0.001, -0.001, 0.01, -0.01), (-0.1, 0.1), 0.002,
        "pressures as they are, without a free offset: they tell where the edges stand at rest", of_stroke=True,
    ),
)  # fmt: skip
OPTIONS.add(
    "threshold",
    ValveOption("a threshold", "threshold", (0.0005, 0.002, 0.008), (0.0, 0.1), 0.002, _SLOWLY, of_stroke=True),
)
OPTIONS.add(
    "flow-curve",
    ValveOption(
        "a flow curve (flow at a tenth of the stroke, over the full one)", "flow_curve.1.1",
        (-0.03, 0.03, -0.06, 0.1), (-0.09, 0.4), 0.02,
        "a valve test that opens it to some tenths of its stroke: near null alone it is another flow gain",
        neutral=0.1, set={"flow_curve": [[0.0, 0.0], [0.1, 0.1], [1.0, 1.0]]},
    ),
)  # fmt: skip

"""What all that shows levels of a run says of them."""

from typing import Final

from ehamj.judge.faults import WHOLE
from ehamj.report.shown import Shown

OF_LEVELS: Final = "Of the RMS over the whole run."
"""What attenuation is of."""
HEADLINE_BANDS: Final = ("5", "10", "20", "50", "100")
MIXED: Final = f" Where something failed: {WHOLE}; see Faults for each part."


def mixed_in(shown: Shown) -> str:
    """What to know of levels of the whole run, where something failed in one."""
    return MIXED if any(result.summary.mixed for result in shown.results.values()) else ""

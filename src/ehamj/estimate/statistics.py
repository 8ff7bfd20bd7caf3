"""What a level may be of: the statistics of a motion over a run, by the names that files use."""

from typing import Final, Literal

BandStatistic = Literal["rms", "max_1s", "slow", "fast", "l10", "l50", "l90"]
"""Of the motion in a third-octave band."""
Statistic = BandStatistic | Literal["peak"]
"""``peak``: largest absolute value of the whole history, all frequencies together."""

WORDS: Final[dict[Statistic, str]] = {
    "rms": "RMS over the whole run",
    "max_1s": "largest sliding 1 s RMS",
    "slow": "largest slow weighted level (1 s)",
    "fast": "largest fast weighted level (0.125 s)",
    "l10": "1 s RMS exceeded for 10 % of the time",
    "l50": "1 s RMS exceeded for 50 % of the time",
    "l90": "1 s RMS exceeded for 90 % of the time",
    "peak": "peak of the whole history",
}
"""Every statistic in words."""

SHORT: Final[dict[Statistic, str]] = {
    "rms": "whole-run RMS",
    "max_1s": "largest 1 s RMS",
    "slow": "largest slow level",
    "fast": "largest fast level",
    "l10": "L10 of 1 s RMS",
    "l50": "L50 of 1 s RMS",
    "l90": "L90 of 1 s RMS",
    "peak": "peak",
}
"""Every statistic in a few words, as they stand before the name of what is measured."""

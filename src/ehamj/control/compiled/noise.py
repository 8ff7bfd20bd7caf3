"""Noise and drift of readings from random numbers, compiled."""

from functools import cache
from typing import Any

FACTORS = ("white", "kick", "decay", "walk", "drift")
"""Of each channel: of the white noise, of what a sample adds to the rising noise, of what is left of it a sample later,
of what a sample adds to the walk, and the drift [unit/s]."""


@cache
def compiled_noise() -> Any:
    """The function that makes readings' noise of standard normal numbers.

    Its arguments: the numbers (channel, sample, 3): white, rising, walking; number of the first sample; period [s];
    `FACTORS` (channel, 5); sections of second order of the low-passes (channel, section, 6); how many of them each
    channel has (channel,), −1 for one that is silent; what is remembered: rising noise and walk (channel, 2), states of
    the low-passes (channel, section, 2); the noise that is found (sample, channel).
    """
    import numba

    from ehamj.compiled.kept import compiled

    def colour(drawn, first, period, factors, sections, counts, levels, filtered, found):  # type: ignore[no-untyped-def]
        for c in range(counts.size):
            white, kick, decay, walk, drift = factors[c]
            slow, walked = levels[c, 0], levels[c, 1]
            for k in range(found.shape[0] if counts[c] >= 0 else 0):
                slow = decay * slow + kick * drawn[c, k, 1]
                walked += walk * drawn[c, k, 2]
                value = white * drawn[c, k, 0] + slow
                for s in range(counts[c]):
                    own, states, given = sections[c, s], filtered[c, s], value
                    value = own[0] * given + states[0]
                    states[0] = own[1] * given - own[4] * value + states[1]
                    states[1] = own[2] * given - own[5] * value
                found[k, c] = value + walked + drift * ((first + k) * period)
            levels[c, 0], levels[c, 1] = slow, walked

    f8, i8 = numba.float64, numba.int64
    tables = (f8[:, ::1], f8[:, :, ::1], i8[::1], f8[:, ::1], f8[:, :, ::1])
    return compiled(colour, numba.void(f8[:, :, ::1], i8, f8, *tables, f8[:, :]))

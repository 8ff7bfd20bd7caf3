"""What of a run counts for levels: from when on, and with what weight near its two ends."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from scipy.fft import rfft

from ehamj.arrays import Array
from ehamj.columns import Samples, blocks, columns, digest
from ehamj.estimate.bands import Band
from ehamj.signals import rise

LONGEST_TAPER: Final = 0.5
"""Time over which the weight rises and falls at most [s]."""


LONG: Final = 2**20
"""Samples from which on what is the same of all channels is not kept for the next: it takes as much as a channel."""
LEAST_BINS: Final = 4
"""Bandwidth times counted time that a band must have for its level to be stated."""


def settled(duration: float) -> float:
    """Time from which levels are taken, so that the beginning does not count [s].

    A tenth of the run, at most 1 s; of runs beyond 20 s a twentieth, at most 2 s.
    """
    return min(2.0, max(min(1.0, 0.1 * duration), 0.05 * duration))


@dataclass(frozen=True)
class Counted:
    """Samples ``n`` of a run from time 0 at ``rate`` [Hz], of which those count that come when it has `settled`.

    All that counts has the weight one, but for the very end: there it falls to zero over ``taper`` [s], as it rises
    from zero before ``begin`` (the quintic of `ehamj.signals.rise`).
    """

    n: int
    rate: float

    @cached_property
    def begin(self) -> float:
        """Time from which levels are taken [s]."""
        return settled(max(self.n - 1, 0) / self.rate)

    @property
    def taper(self) -> float:
        """Time over which the weight rises and falls [s]; it fits into what is left out."""
        return min(LONGEST_TAPER, self.begin)

    @property
    def end(self) -> float:
        """Time of the last sample [s]."""
        return (self.n - 1) / self.rate

    @property
    def first(self) -> int:
        """The first sample that has a weight."""
        return int(np.floor((self.begin - self.taper) * self.rate + 1e-6))

    @cached_property
    def start(self) -> int:
        """The first sample that counts."""
        return int(np.ceil(self.begin * self.rate - 1e-6))

    @cached_property
    def length(self) -> float:
        """How long is counted, to the end [s]."""
        return (self.n - self.start) / self.rate

    def decides(self, band: Band, least_bins: float = LEAST_BINS) -> bool:
        """Whether the record is long enough, and sampled fast enough, for a band's level to be stated."""
        return band.width * self.length >= least_bins and band.edges[1] <= 0.5 * self.rate

    @cached_property
    def weight(self) -> Array:
        """Of each sample, (n,)."""
        if self.taper == 0.0:
            return np.zeros(self.n)
        found = np.empty(self.n)
        for rows in blocks(self.n):
            time = np.arange(rows.start, rows.stop) / self.rate
            inside = np.minimum(time - (self.begin - self.taper), self.end - time)
            found[rows] = rise(inside / self.taper).value
        return found

    @cached_property
    def seconds(self) -> float:
        """Time that the energy of a stationary signal is of: ∫ weight² dt [s]."""
        return float((self.weight**2).sum()) / self.rate


PLANS: Final = 16
"""Lengths whose plans a library of transforms keeps at most."""


def forget_plans(samples: int) -> None:
    """Let SciPy and NumPy forget how they transform long records, of so many samples.

    Both keep what they have worked out for the last `PLANS` lengths, which takes as much as a record each: short ones
    take their places.
    """
    if samples > LONG:
        for size in range(2, 2 + PLANS):
            rfft(np.zeros(size))
            np.fft.rfft(np.zeros(size))


def of_all(kept: Any, samples: int) -> Callable[..., Any]:
    """What computes something that is the same of all channels of so many samples: as it is ``kept``, or anew."""
    computed: Callable[..., Any] = kept if samples <= LONG else kept.__wrapped__
    return computed


def by_column(samples: Samples, compute: Callable[[Array], Array]) -> Array:
    """What a function makes of each channel of samples (n, …); channels that are the same are computed once.

    Args:
        samples: at least one channel.
        compute: from (n,) to an array of any shape S.

    Returns:
        (*S, …), the channels' shape last.
    """
    known: dict[bytes, Array] = {}
    found = []
    for whole in columns(samples):
        key = digest(whole)
        if key not in known:
            known[key] = compute(whole)
        found.append(known[key])
    together = np.stack(found, axis=-1)
    return together.reshape(*together.shape[:-1], *samples.shape[1:])

"""What is believed of a channel's error: how large it is, and how its samples go together."""

from dataclasses import dataclass

from ehamj.arrays import Array


@dataclass(frozen=True)
class Noise:
    """Of one channel: standard deviation of each sample (n,), and the autoregression a of its errors over it,
    eₜ = a₁ eₜ₋₁ + … + wₜ; () where they are white."""

    deviation: Array
    regression: tuple[float, ...] = ()
    innovation: float = 1.0
    """Deviation of w over that of e."""

    def whitened(self, values: Array) -> Array:
        """Errors, or derivatives of predictions, (n,) or (n, k) as real numbers, of unit variance and white."""
        of = values / (self.deviation if values.ndim == 1 else self.deviation[:, None])
        found = of.copy()
        for lag, share in enumerate(self.regression, 1):
            found[lag:] -= share * of[:-lag]
        if not self.regression:
            return found
        return found[len(self.regression) :] / self.innovation

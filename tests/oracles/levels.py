"""Third-octave levels written from their definition: the energy of all that counts, between the band's edges."""

import numpy as np


def whole_run_rms(samples: np.ndarray, rate: float, begin: float, centre: float) -> float:
    """RMS over a run from ``begin`` on, of samples (n,) from time 0, in the third-octave about ``centre`` [Hz].

    Weights rise (cosines) within half a second before ``begin``, and fall within the last half second.
    """
    taper, time = min(0.5, begin), np.arange(samples.size) / rate
    inside = np.clip(np.minimum(time - begin + taper, time[-1] - time) / taper, 0.0, 1.0)
    weight = np.sin(0.5 * np.pi * inside) ** 2
    size = 8 * samples.size
    energy = 2.0 * np.abs(np.fft.rfft(samples * weight, size)) ** 2 / size
    frequency = np.fft.rfftfreq(size, 1.0 / rate)
    within = (frequency > centre * 10**-0.05) & (frequency < centre * 10**0.05)
    return float(np.sqrt(energy[within].sum() / (weight**2).sum()))

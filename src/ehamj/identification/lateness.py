"""Channels whose errors, after the fit, go as a delay would make them: clocks that are a little apart."""

from typing import Final

import numpy as np

from ehamj.identification.fit import Fitted

SURE: Final = 6.0
"""Deviations from which a delay is told."""
LEAST: Final = 0.05
"""Of it in samples, from which it is worth a word."""


def late_channels(fit: Fitted) -> list[tuple[str, str, float, float]]:
    """Test, channel, delay and its standard deviation [s] of channels that come late (or early, negative), and whose
    delay is not free. What values of the fit can make of a delay is taken out of it first."""
    found = []
    for test, channel, noise, slopes in zip(fit.at.tests, fit.at.compared, fit.noise, fit.at.slopes, strict=True):
        free = any(name.endswith(".delay") for name in channel.slopes)
        if channel.axis != "time" or free or len(channel.at) < 50:
            continue
        rate = (len(channel.at) - 1) / float(channel.at[-1] - channel.at[0])
        moved = noise.whitened(-np.gradient(np.asarray(channel.predicted.real)) * rate)
        fitted = noise.whitened(slopes)
        fitted = fitted[:, np.abs(fitted).max(axis=0) > 0.0]
        if fitted.size:
            fitted = fitted / np.linalg.norm(fitted, axis=0)
            moved = moved - fitted @ np.linalg.lstsq(fitted, moved, rcond=1e-10)[0]
        size = float(moved @ moved)
        if size <= 0.0:
            continue
        error = noise.whitened(channel.error)
        delay, deviation = float(moved @ error) / size, float(np.std(error)) / np.sqrt(size)
        if abs(delay) > SURE * deviation and abs(delay) * rate > LEAST:
            found.append((test, channel.name, delay, float(deviation)))
    return found

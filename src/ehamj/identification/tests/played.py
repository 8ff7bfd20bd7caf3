"""A linear model played the inputs of a record, and its outputs averaged as the record's were.

Segments that are short beside how long a resonance rings leak: Welch's responses of the very model differ from its own.
What is compared goes through the same averaging on both sides, so that only noise is left between them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import scipy

from ehamj.arrays import Array, ComplexArray
from ehamj.estimate.spectra import Spectra, segments
from ehamj.linear.machine import LinearModel
from ehamj.measured.measured import Measured

RINGS: Final = 4.0
"""Time behind a record in which it rings out, so that its end does not come before its beginning [s]."""
ABOVE: Final = 1.2
"""Frequencies over the band's end up to which the model is played: what is above leaks into none of it."""
ALIKE: Final = 1e-6
"""Difference of responses by eigenvectors from those by elimination, over their size, at most."""
TRIED: Final = 5
"""Frequencies at which both are compared."""


@dataclass(frozen=True)
class Averaging:
    """What makes of a model's responses those that Welch's spectra of the record would show of it."""

    hertz: Array = field(repr=False)
    """Frequencies at which the model is asked [Hz], (F,)."""
    inputs: ComplexArray = field(repr=False)
    """The record's inputs there, (F, q)."""
    lines: ComplexArray = field(repr=False)
    """Their segments' lines, (segment, f, q)."""
    shares: ComplexArray = field(repr=False)
    """What makes of E[y xᴴ], (f, q), the compared response to each input, (f, q, q)."""
    kept: Array = field(repr=False)
    """Which of the segments' lines are compared, (line,)."""
    rate: float
    """[Hz]"""
    padded: int
    part: slice
    """Samples that are averaged."""
    segment: float
    """[s]"""

    def parts(self, response: ComplexArray) -> ComplexArray:
        """Of responses at `hertz`, (F, p, q): what each input contributes to each compared one, (f, p, q, q), summed
        over the third axis the response to the input of the fourth."""
        _, p, q = response.shape
        whole = np.zeros((self.padded // 2 + 1, p * q), complex)
        whole[1 : 1 + self.hertz.size] = (response * self.inputs[:, None, :]).reshape(-1, p * q)
        played = scipy.fft.irfft(whole, self.padded, axis=0)[self.part]
        found = segments(played, self.rate, self.segment).lines[:, self.kept].reshape(-1, self.kept.sum(), p, q)
        spectra = np.einsum("sfpk,sfi->fpki", found, self.lines.conj()) / len(found)
        return np.asarray(spectra @ self.shares[:, None])


def averaging(measured: Measured, first: int, spectra: Spectra, kept: Array, length: float, top: float) -> Averaging:
    """Of a record.

    Args:
        measured: inputs and outputs.
        first: samples at its beginning that are left out.
        spectra: Welch's, of all lines.
        kept: which of them are compared.
        length: of a segment [s].
        top: highest frequency that is compared [Hz].
    """
    whole = np.column_stack([channel.samples - channel.samples.mean() for channel in measured.inputs])
    padded = scipy.fft.next_fast_len(len(whole) + round(RINGS * measured.rate), real=True)
    padded += padded % 2
    most = min(int(ABOVE * top / measured.rate * padded) + 1, padded // 2)
    hertz = np.arange(1, most + 1) * measured.rate / padded
    found = scipy.fft.rfft(whole, padded, axis=0)[1 : most + 1]
    lines = segments(whole[first:], measured.rate, length).lines[:, kept]
    return Averaging(
        hertz, found, lines, _shares(spectra.xx[kept]), kept, measured.rate, padded, slice(first, len(whole)), length
    )


def _shares(xx: ComplexArray) -> ComplexArray:
    """E[y xᴴ] → E[y xᴴ] L⁻ᴴ / L_jj with E[x xᴴ] = L Lᴴ, (f, q, j)."""
    scale = np.sqrt(np.maximum(np.einsum("fqq->fq", xx).real, 1e-300))
    root = np.linalg.cholesky(xx / scale[:, :, None] / scale[:, None, :] + 1e-12 * np.eye(xx.shape[1]))
    inverse = np.linalg.inv(root).conj().transpose(0, 2, 1) / scale[:, :, None]
    own = np.einsum("fqq->fq", root).real * scale
    return np.asarray(inverse / own[:, None, :])


def fine_response(model: LinearModel, hertz: Array, outputs: Sequence[str], inputs: Sequence[str]) -> ComplexArray:
    """Response of a model at very many frequencies, (F, output, input), by its eigenvectors, where they tell it."""
    C, D = model.rows(outputs)
    columns = [model.inputs.index(name) for name in inputs]
    B, D = model.B[:, columns], D[:, columns]
    _, (scale, _) = scipy.linalg.matrix_balance(model.A, permute=False, separate=True)
    values, vectors = np.linalg.eig(model.A * scale / scale[:, None])
    into, out = np.linalg.solve(vectors, B / scale[:, None]), (C * scale) @ vectors
    s = 2j * np.pi * hertz
    found = (out[None] / (s[:, None, None] - values)) @ into + D
    some = np.unique(np.linspace(0, hertz.size - 1, TRIED).astype(int))
    exact = model.response(hertz[some], outputs, inputs)
    if np.abs(found[some] - exact).max(initial=0.0) > ALIKE * np.abs(exact).max(initial=0.0):
        return np.asarray(model.response(hertz, outputs, inputs))
    return np.asarray(found)

"""Responses of a record: outputs over inputs by Welch's spectra, for the linear model to be compared with.

Inputs that go together leave errors of single responses that go together as well. So of several inputs the response to
each is compared beside what the others share with it: H L/L_jj with G_xx = L Lᴴ, whose errors are those of each column
by itself (for inputs that have nothing in common it is H). Lines of Hann's window share (2/3)² of their power with
their neighbours and (1/6)² with the next ones: every second one is compared, which tells as much as all, each by
itself.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.estimate.spectra import Spectra
from ehamj.identification.tests.linear import Line
from ehamj.identification.tests.played import Averaging, averaging
from ehamj.measured.measured import Measured, MeasuredChannel

SHARED: Final = 1.0 + 2.0 / 36.0
"""Every second line of Hann's window that tell as much as one alone."""
SEGMENT: Final = 2.0
"""Length of a segment, where the record has room for `SEGMENTS` of it [s]."""
SEGMENTS: Final = 8
FAINT: Final = 1e-4
"""Power of an input at a frequency, over its largest, below which nothing is compared."""
LEAST: Final = 1e-9
"""Part of an output that no input explains at least."""


def averaged(
    measured: Measured, begin: float, band: tuple[float, float], segment: float | None
) -> tuple[Array, tuple[Line, ...], Averaging]:
    """Frequencies [Hz] and compared responses of a record, and what averages a model's alike.

    Args:
        measured: inputs and outputs.
        begin: time at its beginning that is left out [s].
        band: frequencies that are compared [Hz].
        segment: length of a segment [s]; None: 2 s, or an eighth of the record.

    Raises:
        InputError: if there is no input, or the record is too short for its inputs.
    """
    if not measured.inputs:
        raise InputError(
            f"test {measured.name!r}: compared in frequency, a record must have inputs: a valve_command, a ground_… "
            "channel or a force among its measurement"
        )
    first = round(begin * measured.rate)
    inputs, outputs = (_stacked(side, first) for side in (measured.inputs, measured.outputs))
    length = min(SEGMENT, len(inputs) / measured.rate / SEGMENTS) if segment is None else segment
    spectra = Spectra.welch(inputs, outputs, measured.rate, length)
    q, n = inputs.shape[1], float(spectra.averages[0])
    if n < q + 2:
        raise InputError(
            f"test {measured.name!r}: segment = {length:g} s leaves {n:.1f} averages for {q} inputs; at least {q + 2} "
            "are needed: a shorter segment, or a longer record"
        )
    power = np.einsum("fqq->fq", spectra.xx).real
    usable = (power > FAINT * power.max(axis=0)).any(axis=1)
    inside = (spectra.frequency >= band[0]) & (spectra.frequency <= min(band[1], measured.usable_to))
    kept = usable & inside & (np.arange(usable.size) % 2 == 1)
    if not kept.any():
        raise InputError(f"test {measured.name!r}: no input excites anything from {band[0]:g} to {band[1]:g} Hz")
    lines = [line for p in range(len(measured.outputs)) for line in _lines(measured, spectra, kept, p)]
    top = float(spectra.frequency[kept][-1])
    return spectra.frequency[kept], tuple(lines), averaging(measured, first, spectra, kept, length, top)


def _stacked(channels: Sequence[MeasuredChannel], first: int) -> Array:
    return np.column_stack([channel.samples[first:] for channel in channels])


def _lines(measured: Measured, spectra: Spectra, kept: Array, p: int) -> list[Line]:
    """Of one output, a line for each input."""
    xx, yx, yy = spectra.xx[kept], spectra.yx[kept, p], spectra.yy[kept, p, p].real
    q = xx.shape[1]
    scale = np.sqrt(np.maximum(np.einsum("fqq->fq", xx).real, 1e-300))
    normed = xx / scale[:, :, None] / scale[:, None, :] + 1e-12 * np.eye(q)
    root = np.linalg.cholesky(normed)
    # H L = G_yx G_xx⁻¹ L = G_yx L⁻ᴴ
    product = np.linalg.solve(root, (yx / scale).conj()[:, :, None])[:, :, 0].conj()
    explained = (np.abs(product) ** 2).sum(axis=1)
    left = np.maximum(yy - explained, LEAST * yy)
    deviation = np.sqrt(SHARED * left / (spectra.averages[kept] - q))
    found = []
    for j, channel in enumerate(measured.inputs):
        own = root[:, j, j].real * scale[:, j]
        mixture = root[:, :, j] * scale / own[:, None]
        name = f"{measured.outputs[p].name} / {channel.name}"
        coherence = np.abs(product[:, j]) ** 2 / np.maximum(yy - explained + np.abs(product[:, j]) ** 2, 1e-300)
        found.append(Line(name, p, mixture, product[:, j] / own, deviation / own, coherence))
    return found

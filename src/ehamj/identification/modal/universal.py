"""Frequency responses of a universal file as those of a machine's places to forces, of which modes are found."""

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError
from ehamj.identification.modal.responses import Mobilities
from ehamj.measured.responses.raw import RawResponse
from ehamj.measured.responses.reading import SAME
from ehamj.measured.responses.uff import read_uff
from ehamj.measured.responses.variance import LEAST
from ehamj.measured.sensors import KINDS
from ehamj.records.units import powers
from ehamj.settings import Band

PER_FORCE: Final = (0, 2, 0, 0, -1, 0, 0)
"""Powers of the base units of a displacement over a force: m/N = s²/kg."""


def mobilities_of(path: Path, band: Band | None = None) -> Mobilities:
    """The responses of a universal file, at the places that its nodes are.

    Of a hammer that went round while one sensor stood still, the places are those that were hit: a motion here by a
    force there is a motion there by the same force here (Maxwell and Betti).

    Args:
        path: of the file.
        band: of which lines count [Hz]; None: all.

    Raises:
        ValueError: if it cannot be read.
        InputError: if a response is missing, is none of a motion to a force, or there are no lines in the band.
    """
    raws = read_uff(path)
    told = f"file = {path.name!r}"
    outputs, inputs = (list(dict.fromkeys(getattr(raw, side) for raw in raws)) for side in ("output", "input"))
    each = {(raw.output, raw.input): raw for raw in raws}
    for o in outputs:
        for i in inputs:
            if (o, i) not in each:
                raise InputError(f"{told}: the response of {o} to {i} is missing; leave {o} or {i} out of the file")
    if len(each) < len(raws):
        twice = next(raw.told for raw in raws if each[raw.output, raw.input] is not raw)
        raise InputError(f"{told} holds {twice} twice; leave one of them out of it")
    hertz = raws[0].frequency
    for raw in raws:
        if raw.frequency.shape != hertz.shape or np.abs(raw.frequency - hertz).max() > SAME * hertz[-1]:
            raise InputError(f"{told}: {raw.told} is at other frequencies than {raws[0].told}; make them two files")
    kept = (hertz > 0.0) if band is None else (hertz >= max(band[0], 1e-9)) & (hertz <= band[1])
    if not kept.any():
        raise InputError(f"{told}: responses are from {hertz[0]:g} to {hertz[-1]:g} Hz; no line is in the band")
    shape = (int(kept.sum()), len(outputs), len(inputs))
    parts = [_mobility(each[o, i], kept, told) for o in outputs for i in inputs]
    values, deviation = (np.stack(one, axis=1).reshape(shape) for one in zip(*parts, strict=True))
    words = f"frequency responses of {path.name}, {len(outputs)} motions to {len(inputs)} forces"
    if len(inputs) > len(outputs):
        words = f"{words}, shapes at the places that were hit"
        outputs, values, deviation = inputs, values.transpose(0, 2, 1), deviation.transpose(0, 2, 1)
    return Mobilities(tuple(outputs), hertz[kept], values, deviation, words)


def _mobility(raw: RawResponse, kept: NDArray[np.bool_], told: str) -> tuple[ComplexArray, Array]:
    """Acceleration over force (f,), and the deviation of each value over that of the others, by the coherence."""
    values = raw.values[kept] * (2j * np.pi * raw.frequency[kept]) ** (2 - _order(raw, told))
    if not np.isfinite(values).all():
        raise InputError(f"{told}: {raw.told} holds values that are not finite; leave it out of the file")
    size = np.abs(values)
    if not size.any():
        raise InputError(f"{told}: {raw.told} is zero everywhere; leave it out of the file")
    if raw.coherence is None:
        return values, np.full(values.size, float(np.sqrt(np.mean(size**2))))
    coherence = np.clip(raw.coherence[kept], 1e-6, 1.0)
    if not np.isfinite(coherence).all():
        raise InputError(f"{told}: the coherence of {raw.told} holds values that are not finite")
    return values, np.maximum(size, 1e-9 * size.max()) * np.sqrt((1.0 - coherence) / coherence + LEAST**2)


def _order(raw: RawResponse, told: str) -> int:
    """How often a displacement was differentiated: 2 of an acceleration over a force."""
    if raw.unit is None:
        if raw.motion in KINDS:
            return KINDS.index(raw.motion)
        raise InputError(
            f"{told}: nothing says what {raw.told} is in: label its ordinate (m/s^2) and its denominator (N), or state "
            "their data types (12 and 13)"
        )
    try:
        found = powers(raw.unit)[1:]
    except ValueError as error:
        raise InputError(f"{told}: the unit of {raw.told}: {error}") from None
    seconds = int(PER_FORCE[1] - found[1])
    if seconds not in (0, 1, 2) or tuple(found) != (0, PER_FORCE[1] - seconds, *PER_FORCE[2:]):
        raise InputError(
            f"{told}: {raw.told} is in {raw.unit}, which is no motion over a force; modes are found in accelerations, "
            "velocities or displacements over forces"
        )
    return seconds

"""Records in WAV files, whose samples are shares of a full scale that the user states."""

import warnings
from functools import partial
from pathlib import Path

import numpy as np
from scipy.io import wavfile

from ehamj.records.channel import Record
from ehamj.records.choices import SILENT, Choices
from ehamj.records.components import Component, Loaded, existing, reading, record_of

CLIPPED = 1.0 - 1e-4
"""Share of the full scale from which a sample counts as clipped."""


def read_wav(path: Path, choices: Choices = SILENT) -> Record:
    """A WAV record: ``choices.full_scale`` is the motion that the largest possible sample stands for.

    Integers count from -1 to 1 of the full scale, floating-point samples are shares of it already. Components are
    called by their number, from ``1``. Raises ValueError where the file cannot be read or is truncated, and where the
    full scale or the quantity is not given.
    """
    if choices.full_scale is None:
        raise ValueError(
            "ground.full_scale is missing: a WAV file does not say what its samples mean; give the motion that its "
            "largest sample stands for, in ground.unit"
        )
    existing(path)
    with reading(path, " as WAV"), warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        rate, data = wavfile.read(path)
    cut = next((str(entry.message) for entry in said if "EOF" in str(entry.message)), None)
    if cut is not None:
        raise ValueError(f"ground.file = {path.name!r} is truncated: {cut}")
    if rate <= 0:
        raise ValueError(f"ground.file = {path.name!r} states a sampling rate of {rate} Hz; it must be positive")
    share = _share(data[:, None] if data.ndim == 1 else data)
    full_scale = choices.full_scale

    def load(column: int) -> Loaded:
        samples = share[:, column]
        over = int(np.sum(np.abs(samples) >= CLIPPED))
        notes = [f"{column + 1} looks clipped: {over} samples stand at the WAV file's full scale"] if over else []
        return Loaded(full_scale * samples, float(rate), notes=tuple(notes))

    components = [Component(str(n + 1), partial(load, n)) for n in range(share.shape[1])]
    return record_of(path.name, components, choices, "use a format that states it")


def _share(data: np.ndarray) -> np.ndarray:
    """Samples as shares of the full scale."""
    if data.dtype.kind == "f":
        return np.asarray(data, float)
    if data.dtype.kind == "u":  # 8 bit, around 128
        return (data.astype(float) - 128.0) / 128.0
    return data.astype(float) / -float(np.iinfo(data.dtype).min)

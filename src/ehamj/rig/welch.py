"""Transmissibility measured from a stored run by Welch's method, whatever moved its floor."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ehamj.errors import InputError
from ehamj.estimate.spectra import Estimator, Spectra, estimate, segments
from ehamj.judge import settled
from ehamj.linear.response import TURNS, lever_scale
from ehamj.plant.axes import DOFS
from ehamj.plant.levers import slab_fit
from ehamj.result import Result
from ehamj.rig.measurement import Measurement, channel

SEGMENTS: Final = 16
"""Segments, before overlapping, that a run is divided into where no segment is given, unless they would be longer than
`LONGEST_SEGMENT`."""
LONGEST_SEGMENT: Final = 4.0
"""[s]"""
FAINT: Final = 1e-3
"""Amplitude of an input in a line, over the floor's strongest, below which it counts as at rest: there it shows leakage
and rounding alone. Rotations count as motion at the mounts' mean distance."""


def by_welch(
    result: Result,
    pairs: Sequence[tuple[Sequence[str], Sequence[str]]],
    segment: float | None = None,
    per_octave: float = 24.0,
    estimator: Estimator = "h1",
    confidence: float = 0.95,
) -> list[Measurement]:
    """Measure from a stored run, whatever moved its floor; a rigid slab is fitted to the mounts' motion.

    Args:
        result: of a simulation.
        pairs: outputs (channels of displacement) and inputs (degrees of freedom of the floor), each estimated by
            itself: several inputs are told apart only where they move independently.
        segment: length of the Welch segments [s]; without, a `SEGMENTS`-th of the run, at most `LONGEST_SEGMENT`.
        per_octave: bins per octave in which neighbouring lines are averaged.
        estimator: see `estimate`.
        confidence: see `estimate`.

    Raises:
        InputError: if the run is too short for the segment, or an argument is not allowed.
    """
    if result.dataset.time.size < 2:
        raise InputError("result: nothing was recorded, so that there is nothing to measure")
    rate, duration = result.scenario.record_rate, float(result.dataset.time[-1])
    part = result.dataset.sel(time=slice(settled(duration) - 1e-9, None))
    length = part.time.size / rate
    if segment is None:
        segment = min(LONGEST_SEGMENT, length / SEGMENTS)
    # Velocities: their spectra are flatter than those of displacements, and leak less; the ratio is the same.
    slab = part["ground_velocity"].values.reshape(part.time.size, -1) @ slab_fit(result.scenario.plant.positions).T
    channels = list(dict.fromkeys(name for outputs, _ in pairs for name in outputs))
    answers = np.array([channel(part, name.replace("_displacement ", "_velocity ")) for name in channels]).T
    record = segments(np.hstack([slab, answers]), rate, segment)
    lever = np.where(np.isin(DOFS, TURNS), lever_scale(result.scenario.plant), 1.0)
    power = (np.abs(record.lines[:, :, : len(DOFS)]) ** 2).mean(axis=0) * lever**2
    moves = power > FAINT**2 * power.max(initial=0.0)
    found = []
    for outputs, inputs in pairs:
        columns = [DOFS.index(dof) for dof in inputs]
        rows = [len(DOFS) + channels.index(name) for name in outputs]
        spectra = _only(Spectra.of_segments(record, columns, rows), moves[:, columns]).merged(per_octave)
        words = f"Welch, {record.averages:.0f} averages of {segment:.3g} s or more, {estimator.upper()}"
        found.append(Measurement(tuple(outputs), tuple(inputs), estimate(spectra, estimator, confidence), words))
    return found


def _only(spectra: Spectra, moves: NDArray[np.bool_]) -> Spectra:
    """The spectra with inputs set to zero where they do not move, (f, q)."""
    xx = spectra.xx * (moves[:, :, None] & moves[:, None, :])
    return replace(spectra, xx=xx, yx=spectra.yx * moves[:, None, :])

"""Response spectra of floor, machine and points of a run."""

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.criteria.response_spectrum import frequencies, response_spectrum
from ehamj.criteria.settings import ResponseSpectrumSettings
from ehamj.estimate.counted import by_column, settled
from ehamj.findings import Finding, finite
from ehamj.judge.levels import LEAST_ROWS, duration_of, motions_of
from ehamj.plant.axes import AXES

Peaks = dict[str, dict[str, list[float | None]]]
"""Place → axis → one per natural frequency."""


class ResponseSpectra(Finding):
    """Peak responses of oscillators at each place, None where nothing is known."""

    damping: float
    """Damping ratio [-]."""
    frequency_hz: list[float]
    """Natural frequencies [Hz]."""
    velocity: Peaks
    """Peak pseudo-velocity [m/s]."""
    acceleration: Peaks
    """Peak absolute acceleration [m/s²]."""


def response_spectra(
    dataset: xr.Dataset, rate: float, usable_to: float, settings: ResponseSpectrumSettings
) -> ResponseSpectra:
    """Response spectra: None where the ground is not known, or the run too short.

    The oscillators start from rest with the run; their responses count from where levels are taken. Places are the
    floor (its worst mount at each frequency), the machine's CG and each point.
    """
    natural = frequencies(settings.first, settings.last, settings.per_octave)
    known = natural <= usable_to
    begin = int(np.ceil(settled(duration_of(dataset)) * rate - 1e-6))
    motions = motions_of(dataset, "acceleration")
    del motions["feet"]
    found: dict[str, Peaks] = {"velocity": {}, "acceleration": {}}
    for place, motion in motions.items():
        peaks = np.full((len(found), natural.size, len(AXES)), np.nan)
        if motion.shape[0] - begin >= LEAST_ROWS:

            def of_one(base: Array) -> Array:
                return np.array(response_spectrum(base[:, None], rate, natural[known], settings.damping, begin))[..., 0]

            # A floor that moves as one is computed once; of several mounts the worst counts.
            spectra = by_column(motion, of_one)
            peaks[:, known] = spectra if spectra.ndim < 4 else spectra.max(axis=2)
        for of_place, table in zip(found.values(), peaks, strict=True):
            of_place[place] = {axis: list(map(finite, table[:, k])) for k, axis in enumerate(AXES)}
    return ResponseSpectra(damping=settings.damping, frequency_hz=natural.tolist(), **found)

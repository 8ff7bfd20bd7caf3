"""Response spectra of floor, machine and points of a run."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.criteria.response_spectrum import ResponseSpectrum, frequencies, response_spectrum
from ehamj.criteria.settings import ResponseSpectrumSettings
from ehamj.findings import Finding
from ehamj.judge.levels import LEAST_ROWS, settled
from ehamj.plant.axes import AXES

Array = NDArray[np.float64]


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
    rows = dataset.time.size
    begin = int(np.ceil(settled(float(dataset.time[-1])) * rate - 1e-6)) if rows else 0
    ground = dataset["ground_acceleration"].values
    if np.array_equal(ground, np.broadcast_to(ground[:, :1], ground.shape)):
        ground = ground[:, :1]  # a floor that moves as one
    parts = {"floor": ground, "machine": dataset["cg_acceleration"].values[:, None]}
    if "point_acceleration" in dataset:
        parts |= {str(n): dataset["point_acceleration"].values[:, [k]] for k, n in enumerate(dataset["point"].values)}
    columns = np.column_stack([part.reshape(rows, part.shape[1] * len(AXES)) for part in parts.values()])
    found = {"velocity": np.full((natural.size, columns.shape[1]), np.nan)}
    found["acceleration"] = found["velocity"].copy()
    if rows - begin >= LEAST_ROWS:
        spectrum: ResponseSpectrum = response_spectrum(columns, rate, natural[known], settings.damping, begin)
        found["velocity"][known], found["acceleration"][known] = spectrum.velocity, spectrum.acceleration
    ends = np.cumsum([part.shape[1] * len(AXES) for part in parts.values()])[:-1]
    peaks: dict[str, Peaks] = {
        quantity: {
            place: _by_axis(part.reshape(natural.size, -1, len(AXES)).max(axis=1))
            for place, part in zip(parts, np.split(table, ends, axis=1), strict=True)
        }
        for quantity, table in found.items()
    }
    return ResponseSpectra(damping=settings.damping, frequency_hz=[float(f) for f in natural], **peaks)


def _by_axis(peaks: Array) -> dict[str, list[float | None]]:
    return {axis: [float(v) if np.isfinite(v) else None for v in peaks[:, k]] for k, axis in enumerate(AXES)}

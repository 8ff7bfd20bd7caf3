"""What a shaped floor is shaped to: third-octave levels, a PSD, a file with either, or Peterson's noise models."""

from abc import abstractmethod
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.estimate.bands import band_numbers
from ehamj.ground.spectra import Axis, Spectrum, from_psd, from_third_octaves
from ehamj.records.table_choices import TableChoices
from ehamj.records.tables import Column, read_table
from ehamj.records.units import Quantity, density_unit, motion_unit
from ehamj.settings import FileName, Positive, Settings, one_of
from ehamj.signals import Array


class TargetSettings(Settings):
    """What all of these have."""

    kind: str

    @abstractmethod
    def spectra(self, axes: tuple[Axis, ...]) -> Mapping[Axis, Spectrum]:
        """The spectrum of each axis that moves."""


class ThirdOctaveTarget(TargetSettings):
    """RMS in third-octave bands; bands between two that are given are interpolated, on log-log axes."""

    kind: Literal["third-octave"]
    bands: tuple[Positive, ...] = Field(description="rising nominal centres, such as 8, 10, 12.5 [Hz]", min_length=1)
    levels: tuple[Positive, ...] = Field(description="RMS in each band [SI of quantity]")
    quantity: Quantity = Field("velocity", description="what the levels are of")

    @model_validator(mode="after")
    def _possible(self) -> Self:
        _matching("bands", self.bands, "levels", self.levels)
        band_numbers(self.bands)
        return self

    def spectra(self, axes: tuple[Axis, ...]) -> Mapping[Axis, Spectrum]:
        numbers, levels = band_numbers(self.bands), np.array(self.levels)
        return dict.fromkeys(axes, from_third_octaves(numbers, levels, self.quantity))


class PsdTarget(TargetSettings):
    """A one-sided power spectral density, straight between the points on log-log axes."""

    kind: Literal["psd"]
    frequencies: tuple[Positive, ...] = Field(description="rising frequencies [Hz]", min_length=2)
    density: tuple[Positive, ...] = Field(description="one-sided PSD at each [(SI of quantity)²/Hz]")
    quantity: Quantity = Field("velocity", description="what the PSD is of")

    @model_validator(mode="after")
    def _possible(self) -> Self:
        _matching("frequencies", self.frequencies, "density", self.density)
        return self

    def spectra(self, axes: tuple[Axis, ...]) -> Mapping[Axis, Spectrum]:
        spectrum = from_psd(np.array(self.frequencies), np.array(self.density), self.quantity)
        return dict.fromkeys(axes, spectrum)


class PetersonTarget(TargetSettings):
    """Peterson's new low or high noise model: the envelopes of quiet and of loud seismic sites, from 1e-5 to 10 Hz.

    J. Peterson, *Observations and modeling of seismic background noise*, USGS Open-File Report 93-322 (1993); values
    from ObsPy. Above 10 Hz there is no model: a machine's floor is louder there than either would suggest.
    """

    kind: Literal["peterson"]
    model: Literal["low", "high"] = Field("high", description="new low or high noise model (NLNM, NHNM)")

    def spectra(self, axes: tuple[Axis, ...]) -> Mapping[Axis, Spectrum]:
        from obspy.signal.spectral_estimation import get_nhnm, get_nlnm

        period, level = get_nlnm() if self.model == "low" else get_nhnm()
        order = np.argsort(-period)
        # The last digits of 1/period: the ends are 1e-5 and 10 Hz.
        frequency = np.round(1.0 / period[order], 12)
        return dict.fromkeys(axes, from_psd(frequency, 10.0 ** (level[order] / 10.0), "acceleration"))


class FileTarget(TargetSettings):
    """Third-octave levels or a PSD from a table of text.

    One header line names columns and units. The first column is ``band [Hz]`` (third-octave levels, units such as
    um/s) or ``frequency [Hz]`` (a PSD, units such as (m/s^2)^2/Hz, or m/s/sqrt(Hz) for its root). Columns x, y, z give
    an axis each; one column of another name serves for all axes.
    """

    kind: Literal["file"]
    file: FileName = Field(description="table of text, relative to the scenario's folder", min_length=1)
    table: TableChoices | None = Field(
        None, description="how the table is written, where the file does not show it; as ground.table of records"
    )

    def spectra(self, axes: tuple[Axis, ...]) -> Mapping[Axis, Spectrum]:
        path = Path(self.file)
        found = read_table(path, "ground.target.file", self.table)
        where = found.told
        clock, *rest = found.columns
        if clock.name not in ("band", "frequency") or clock.unit != "Hz" or not rest:
            raise ValueError(f"{where}: the first column must be 'band [Hz]' or 'frequency [Hz]', and levels follow")
        table = found.values()
        if not (np.isfinite(table).all() and (table > 0).all()):
            raise ValueError(f"{where}: every value must be positive and finite")
        if not (np.diff(table[:, 0]) > 0).all() or len(table) < 2:
            raise ValueError(f"{where}: {clock.name} must rise from row to row, in at least 2 rows")
        names = [column.name for column in rest]
        missing = [axis for axis in axes if axis not in names]
        if len(rest) > 1 and missing:
            raise ValueError(f"{where}: it has no column {missing[0]!r} for ground.axes; it has {', '.join(names)}")
        common = len(rest) == 1 and names[0] not in ("x", "y", "z")
        if not common and missing:
            raise ValueError(f"{where}: it has {names[0]!r} only; set ground.axes = [{names[0]!r}]")
        at = {axis: 0 if common else names.index(axis) for axis in axes}
        return {axis: _from_column(rest[k], table[:, 0], table[:, k + 1], clock.name, where) for axis, k in at.items()}


TARGETS: tuple[type[TargetSettings], ...] = (ThirdOctaveTarget, PsdTarget, PetersonTarget, FileTarget)
"""Every kind of target."""

if TYPE_CHECKING:
    Target = TargetSettings
else:
    Target = one_of(TARGETS)


def _matching(key: str, frequencies: tuple[float, ...], other: str, values: tuple[float, ...]) -> None:
    if len(frequencies) != len(values):
        raise ValueError(f"{other} has {len(values)} values; it must have {len(frequencies)}, as {key}")
    falling = next((b for a, b in pairwise(frequencies) if b <= a), None)
    if falling is not None:
        raise ValueError(f"{key} must rise; {falling:g} Hz does not")


def _from_column(column: Column, frequency: Array, values: Array, kind: str, where: str) -> Spectrum:
    """The spectrum of one column of levels (``kind`` band) or of a PSD (``kind`` frequency)."""
    unit = column.unit or ""
    try:
        if kind == "frequency":
            quantity, size, root = density_unit(unit)
            return from_psd(frequency, (size * values) ** 2 if root else size**2 * values, quantity)
        quantity, size = motion_unit(unit)
        return from_third_octaves(band_numbers(frequency), size * values, quantity)
    except ValueError as error:
        raise ValueError(f"{where}: column {column.name!r}: {error}") from error

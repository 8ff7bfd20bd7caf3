"""Transmissibilities as files: one labelled dataset, and tables for a spreadsheet."""

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr

from ehamj.arrays import Array, ComplexArray
from ehamj.labels import labelled
from ehamj.linear.response import unit
from ehamj.result import written_whole
from ehamj.rig.comparison import Comparison


def write_tables(folder: Path, found: Comparison) -> None:
    """Write ``transmissibility.nc``, ``transmissibility.csv`` (a rigid floor; single mounts are in the former) and
    ``attenuation.csv`` into an existing folder."""
    with written_whole(folder / "transmissibility.nc") as path:
        to_dataset(found).to_netcdf(path, engine="h5netcdf")
    head = ("variant", "kind", "output", "input", "unit", "frequency_hz", "magnitude", "phase_deg", "radius",
            "multiple_coherence", "ordinary_coherence")  # fmt: skip
    _write_csv(folder / "transmissibility.csv", head, _rows(found))
    rows = (
        (variant, kind, dof, band.name, "" if np.isnan(level) else f"{level:.6g}")
        for variant, kind, dof, levels in found.attenuation()
        for band, level in zip(found.chosen, levels, strict=True)
    )
    _write_csv(folder / "attenuation.csv", ("variant", "kind", "dof", "band_hz", "attenuation_db"), rows)


def _write_csv(path: Path, head: Sequence[str], rows: Iterator[Sequence[str]]) -> None:
    with written_whole(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(rows)


def _rows(found: Comparison) -> Iterator[Sequence[str]]:
    """A row per variant, kind, element and frequency; linear responses have no coherence."""
    for one in found.elements():
        first = (one.variant, one.kind, one.output, f"floor {one.source}", unit(one.output, one.source))
        for f, value, *sure in zip(one.frequency, one.response, *one.sure, strict=True):
            numbers = (f, abs(value), np.degrees(np.angle(value)), *sure)
            texts = ("" if np.isnan(number) else f"{number:.9g}" for number in numbers)
            yield (*first, *texts, *([""] * (3 - len(sure))))


def to_dataset(found: Comparison) -> xr.Dataset:
    """Everything as one labelled dataset; complex responses as magnitude and phase, NaN where not measured."""
    first, s = found.variants[0], found.settings
    coordinates: dict[str, Any] = {
        "variant": [variant.name for variant in found.variants],
        "output": list(first.linear.outputs),
        "input": list(first.linear.inputs),
        "point": list(first.single.outputs),
        "ground": list(first.single.inputs),
        "frequency": labelled("frequency", first.linear.frequency, "Hz"),
        "band": labelled("band", [band.centre for band in found.chosen], "Hz", "exact centre"),
    }
    data = _polar("linear", ("variant", "frequency", "output", "input"), "floor to machine, linear",
                  np.array([variant.linear.response for variant in found.variants]))  # fmt: skip
    data |= _polar("single_mount", ("variant", "frequency", "point", "ground"), "ground below one mount, linear",
                   np.array([variant.single.response for variant in found.variants]))  # fmt: skip
    grids = [one.estimate.frequency for variant in found.variants for one in variant.measured]
    if grids:
        coordinates["line"] = labelled("line", grids[0], "Hz")
        data |= _measured(found, grids[0])
    for kind in ("linear", "measured"):
        levels = np.full((len(found.variants), len(s.dofs), len(found.chosen)), np.nan)
        for variant, what, dof, values in found.attenuation():
            if what == kind:
                levels[coordinates["variant"].index(variant), s.dofs.index(dof)] = values
        text = f"attenuation per third-octave, {kind}, positive: quieter than the floor"
        data[f"attenuation_{kind}"] = labelled(("variant", "input", "band"), levels, "dB", text)
    attributes = {"title": found.scenario.name, "reference": s.reference, "estimator": s.estimator,
                  "confidence": s.confidence}  # fmt: skip
    return xr.Dataset(data, coordinates, attributes)


UNITS: Final = "m/m, m/rad, rad/m or rad/rad by output and input"


def _polar(name: str, dims: tuple[str, ...], text: str, values: ComplexArray) -> dict[str, Any]:
    return {
        f"{name}_magnitude": labelled(dims, np.abs(values), UNITS, f"{text}, magnitude"),
        f"{name}_phase": labelled(dims, np.degrees(np.angle(values)), "degree", f"{text}, phase"),
    }


def _measured(found: Comparison, grid: Array) -> dict[str, Any]:
    first, names = found.variants[0].linear, [variant.name for variant in found.variants]
    shape = (len(names), grid.size, len(first.outputs), len(first.inputs))
    response, (radius, multiple, ordinary) = np.full(shape, np.nan, complex), np.full((3, *shape), np.nan)
    for one in found.elements():
        if one.kind == "measured":
            at = (
                names.index(one.variant),
                slice(None),
                first.outputs.index(one.output),
                first.inputs.index(one.source),
            )
            response[at] = one.response
            radius[at], multiple[at], ordinary[at] = one.sure
    dims, explain = ("variant", "line", "output", "input"), "share of the output that"
    circle = "radius of the confidence circle about each measured response"
    return _polar("measured", dims, "floor to machine, measured", response) | {
        "confidence_radius": labelled(dims, radius, UNITS, circle),
        "multiple_coherence": labelled(dims, multiple, "1", f"{explain} all inputs together explain"),
        "ordinary_coherence": labelled(dims, ordinary, "1", f"{explain} this input alone explains"),
    }

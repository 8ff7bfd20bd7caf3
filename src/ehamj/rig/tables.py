"""Transmissibilities as files: one labelled dataset, and tables for a spreadsheet."""

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.linear.response import unit
from ehamj.result import written_whole
from ehamj.rig.comparison import Comparison, elements


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

    def row(first: Sequence[str], f: float, value: complex, *more: float) -> Sequence[str]:
        numbers = (f, abs(value), float(np.degrees(np.angle(value))), *more)
        texts = ("" if np.isnan(number) else f"{number:.9g}" for number in numbers)
        return (*first, *texts, *([""] * (3 - len(more))))

    for variant in found.variants:
        linear = variant.linear
        for i, output in enumerate(linear.outputs):
            for j, source in enumerate(linear.inputs):
                first = (variant.name, "linear", output, f"floor {source}", unit(output, source))
                for f, value in zip(linear.frequency, linear.response[:, i, j], strict=True):
                    yield row(first, f, value)
        for one, output, source in elements(variant.measured):
            e, i, j = one.estimate, one.outputs.index(output), one.inputs.index(source)
            first = (variant.name, "measured", output, f"floor {source}", unit(output, source))
            for k, f in enumerate(e.frequency):
                yield row(first, f, e.response[k, i, j], e.radius[k, i, j], e.multiple[k, i], e.ordinary[k, i, j])


def to_dataset(found: Comparison) -> xr.Dataset:
    """Everything as one labelled dataset; complex responses as magnitude and phase, NaN where not measured."""
    first, s = found.variants[0], found.settings
    coordinates: dict[str, Any] = {
        "variant": [variant.name for variant in found.variants],
        "output": list(first.linear.outputs),
        "input": list(first.linear.inputs),
        "point": list(first.single.outputs),
        "ground": list(first.single.inputs),
        "frequency": ("frequency", first.linear.frequency, {"units": "Hz"}),
        "band": ("band", [band.centre for band in found.chosen], {"units": "Hz", "long_name": "exact centre"}),
    }
    data = _polar("linear", ("variant", "frequency", "output", "input"), "floor to machine, linear",
                  np.array([variant.linear.response for variant in found.variants]))  # fmt: skip
    data |= _polar("single_mount", ("variant", "frequency", "point", "ground"), "ground below one mount, linear",
                   np.array([variant.single.response for variant in found.variants]))  # fmt: skip
    grids = [one.estimate.frequency for variant in found.variants for one in variant.measured]
    if grids:
        coordinates["line"] = ("line", grids[0], {"units": "Hz"})
        data |= _measured(found, grids[0])
    for kind in ("linear", "measured"):
        levels = np.full((len(found.variants), len(s.dofs), len(found.chosen)), np.nan)
        for variant, what, dof, values in found.attenuation():
            if what == kind:
                levels[coordinates["variant"].index(variant), s.dofs.index(dof)] = values
        text = f"attenuation per third-octave, {kind}, positive: quieter than the floor"
        data[f"attenuation_{kind}"] = (("variant", "input", "band"), levels, {"units": "dB", "long_name": text})
    attributes = {"title": found.scenario.name, "reference": s.reference, "estimator": s.estimator,
                  "confidence": s.confidence}  # fmt: skip
    return xr.Dataset(data, coordinates, attributes)


UNITS: Final = "m/m, m/rad, rad/m or rad/rad by output and input"


def _polar(name: str, dims: Sequence[str], text: str, values: NDArray[np.complex128]) -> dict[str, Any]:
    return {
        f"{name}_magnitude": (dims, np.abs(values), {"units": UNITS, "long_name": f"{text}, magnitude"}),
        f"{name}_phase": (dims, np.degrees(np.angle(values)), {"units": "degree", "long_name": f"{text}, phase"}),
    }


def _measured(found: Comparison, grid: Array) -> dict[str, Any]:
    first = found.variants[0].linear
    shape = (len(found.variants), grid.size, len(first.outputs), len(first.inputs))
    response, radius = np.full(shape, np.nan, complex), np.full(shape, np.nan)
    multiple, ordinary = np.full(shape, np.nan), np.full(shape, np.nan)
    for v, variant in enumerate(found.variants):
        for one, output, source in elements(variant.measured):
            e, i, j = one.estimate, one.outputs.index(output), one.inputs.index(source)
            at = (v, slice(None), first.outputs.index(output), first.inputs.index(source))
            response[at], radius[at] = e.response[:, i, j], e.radius[:, i, j]
            multiple[at], ordinary[at] = e.multiple[:, i], e.ordinary[:, i, j]
    dims = ("variant", "line", "output", "input")
    data = _polar("measured", dims, "floor to machine, measured", response)
    more = (
        ("confidence_radius", radius, UNITS, "radius of the confidence circle about each measured response"),
        ("multiple_coherence", multiple, "1", "share of the output that all inputs together explain"),
        ("ordinary_coherence", ordinary, "1", "share of the output that this input alone explains"),
    )
    return data | {name: (dims, values, {"units": units, "long_name": text}) for name, values, units, text in more}

"""What was measured and what the model predicts, as a NetCDF file that opens with xarray: a group for each test."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import xarray as xr

from ehamj.arrays import Array

if TYPE_CHECKING:
    from ehamj.identification.outcome import ChannelFit, Identification, TestFit

AXES: Final = {"time": ("s", "time"), "frequency": ("Hz", "frequency"), "number": ("1", "number of the reading")}
"""Unit and name of what samples stand at."""
ABSENT: Final = float("nan")


def write_histories(found: "Identification", path: Path) -> None:
    """Write all tests: parameters at the file's root, the channels of each test in a group of its name.

    Raises:
        OSError: if the file cannot be written.
    """
    parameters(found).to_netcdf(path, engine="h5netcdf")
    for tests, held in ((found.tests, False), (found.validation, True)):
        for test in tests:
            samples(test, held).to_netcdf(path, mode="a", group=plain_name(test.name), engine="h5netcdf")


def parameters(found: "Identification") -> xr.Dataset:
    """Values, deviations and correlations over ``parameter``; of what is not told NaN."""
    keys, values = list(found.values), list(found.values.values())
    about = {
        "value": ([ABSENT if one.value is None else one.value for one in values], "identified value"),
        "deviation": ([ABSENT if one.deviation is None else one.deviation for one in values], "standard deviation"),
        "start": ([one.start for one in values], "value at which the fit began"),
        "low": ([one.bounds[0] for one in values], "least value that was allowed"),
        "high": ([one.bounds[1] for one in values], "largest value that was allowed"),
    }
    variables: dict[str, Any] = {
        name: ("parameter", column, {"long_name": f"{said}, in the parameter's own unit"})
        for name, (column, said) in about.items()
    }
    variables["correlation"] = (
        ("parameter", "other"), found.correlation, {"long_name": "correlation of the errors", "units": "1"},
    )  # fmt: skip
    coordinates = {
        "parameter": ("parameter", keys, {"long_name": "key of the scenario"}),
        "other": ("other", keys, {"long_name": "key of the scenario"}),
        "unit": ("parameter", [one.unit for one in values], {"long_name": "unit of the parameter"}),
        "status": ("parameter", [one.status for one in values], {"long_name": "whether the data tell it"}),
    }
    return xr.Dataset(variables, coordinates, {"title": found.file.title, "scenario": found.scenario.name})


def samples(test: "TestFit", held_out: bool) -> xr.Dataset:
    """Channels of a test: ``NAME_measured``, ``_predicted``, ``_deviation`` and, where there is one, ``_coherence``;
    complex ones by ``_real`` and ``_imag``."""
    axes: list[tuple[str, Array]] = []
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    for one in test.channels:
        dim = _dim(axes, one)
        unit, said = AXES[one.axis]
        coordinates[dim] = (dim, one.at, {"units": unit, "long_name": said})
        variables |= _variables(one, dim)
    attributes = {"title": test.name, "kind": test.kind, "held_out": int(held_out)}
    return xr.Dataset(variables, coordinates, attributes)


def _dim(axes: list[tuple[str, Array]], one: "ChannelFit") -> str:
    """Name of the dimension that a channel stands over: channels at the same places share it."""
    for name, at in axes:
        if name.rstrip("0123456789_") == one.axis and np.array_equal(at, one.at):
            return name
    alike = sum(name.rstrip("0123456789_") == one.axis for name, _ in axes)
    axes.append((f"{one.axis}_{alike + 1}" if alike else one.axis, one.at))
    return axes[-1][0]


def _variables(one: "ChannelFit", dim: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    name = plain_name(one.name)
    for what, values in (("measured", one.measured), ("predicted", one.predicted)):
        parts = {"_real": values.real, "_imag": values.imag} if np.iscomplexobj(values) else {"": values}
        for part, column in parts.items():
            said = f"{one.name}, {what}{part.replace('_', ', ')}"
            found[f"{name}_{what}{part}"] = (dim, column, {"units": one.unit or "1", "long_name": said})
    said = f"{one.name}, standard deviation of its errors"
    found[f"{name}_deviation"] = (dim, one.deviation, {"units": one.unit or "1", "long_name": said})
    if one.coherence is not None:
        said = f"{one.name}, coherence"
        found[f"{name}_coherence"] = (dim, one.coherence, {"units": "1", "long_name": said})
    return found


def plain_name(name: str) -> str:
    """A name that NetCDF takes: words joined by underscores, "OUTPUT / INPUT" as "OUTPUT_over_INPUT"."""
    return re.sub(r"[^\w.-]+", "_", name.replace(" / ", " over ")).strip("_") or "_"

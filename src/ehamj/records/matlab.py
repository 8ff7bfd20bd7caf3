"""Records in MATLAB files, up to version 7.2 through SciPy and from 7.3 (HDF5) through h5py."""

from functools import partial
from pathlib import Path

import numpy as np

from ehamj.plain.matlab import check_matlab
from ehamj.records.channel import Record
from ehamj.records.choices import SILENT, Choices
from ehamj.records.clock import clock, on_grid
from ehamj.records.components import Component, Loaded, answers_of, existing, reading, record_of
from ehamj.signals import Array

CLOCKS = ("time", "t")
RATES = ("rate_hz", "fs", "Fs")


def read_matlab(path: Path, choices: Choices = SILENT) -> Record:
    """The numeric vectors of a MATLAB file.

    A vector ``time`` or ``t`` [s], or a number ``rate_hz``, ``fs`` or ``Fs`` [Hz], gives the times; every other vector
    as long as the longest is a component of its own name, and the columns of a matrix are called ``name(1)``,
    ``name(2)``, … Quantity and unit are the user's to say. Raises ValueError where the file cannot be read, or where
    clock or components are missing.
    """
    arrays = _arrays(path)
    where = f"ground.file = {path.name!r}"
    times = [name for name in CLOCKS if name in arrays and arrays[name].size > 1]
    rates = [name for name in RATES if name in arrays and arrays[name].size == 1]
    if len(times) + len(rates) != 1:
        there = ", ".join(times + rates) or "none"
        raise ValueError(
            f"{where}: give a vector {' or '.join(CLOCKS)} [s] or a number {', '.join(RATES)} [Hz]; there is {there}"
        )
    columns: dict[str, Array] = {}
    for name, array in arrays.items():
        if name not in (*CLOCKS, *RATES) and array.size > 1 and array.ndim == 2:
            long = array if array.shape[0] >= array.shape[1] else array.T
            one = long.shape[1] == 1
            columns |= {name if one else f"{name}({n + 1})": column for n, column in enumerate(long.T)}
    length = max((column.size for column in columns.values()), default=0)
    columns = {name: column for name, column in columns.items() if column.size == length}
    if not columns:
        raise ValueError(f"{where} holds no vector of numbers that could be a component")
    notes: list[str] = []
    if times:
        time = arrays[times[0]].ravel()
        if time.size != length:
            raise ValueError(f"{where}: {times[0]} has {time.size} values and the components have {length}")
        rate, index, notes = clock(time, path.name, choices.gaps)
    else:
        rate, index = float(arrays[rates[0]].ravel()[0]), np.arange(float(length))
        if not 0 < rate < np.inf:
            raise ValueError(f"{where}: {rates[0]} = {rate:g} must be a positive number, in Hz")
    components = [
        Component(name, partial(_loaded, index, rate, column), answers_of(name)) for name, column in columns.items()
    ]
    return record_of(path.name, components, choices, "write a format that states it", notes)


def _loaded(index: Array, rate: float, column: Array) -> Loaded:
    return Loaded(on_grid(index, column), rate)


def _arrays(path: Path) -> dict[str, Array]:
    """The file's real numeric variables, two-dimensional as MATLAB has them."""
    from scipy.io import loadmat

    existing(path)
    with reading(path, " as a MATLAB file"):
        check_matlab(path)
        try:
            content = loadmat(str(path))
        except NotImplementedError:
            content = _hdf5(path)
    return {
        name: np.atleast_2d(np.asarray(value, float))
        for name, value in content.items()
        if not name.startswith("__") and isinstance(value, np.ndarray) and value.dtype.kind in "iuf"
    }


def _hdf5(path: Path) -> dict[str, np.ndarray]:
    import h5py

    with h5py.File(path) as file:
        # Not by items(), which keeps h5py's lock until it is exhausted, also where an array cannot be read.
        held = {name: file[name] for name in list(file)}
        return {name: np.asarray(part).T for name, part in held.items() if isinstance(part, h5py.Dataset)}

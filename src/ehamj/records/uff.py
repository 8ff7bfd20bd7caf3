"""Records in universal files (UFF): time responses of dataset 58, through pyuff."""

import re
import tempfile
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ehamj.records.channel import Place, Record
from ehamj.records.choices import SILENT, Choices
from ehamj.records.clock import clock, on_grid
from ehamj.records.components import Component, Loaded, record_of
from ehamj.records.files import existing, reading
from ehamj.records.units import Quantity, is_silent, kind_of, motion_unit, time_unit

DIRECTIONS: dict[int, Place] = {1: "x", 2: "y", 3: "z"}
DATA_TYPES: dict[int, Quantity] = {8: "displacement", 11: "velocity", 12: "acceleration"}
TIME_RESPONSE = 1
"""Function type of a time response."""

TIME_TYPES = (0, 1, 17)
"""Data types that the abscissa of a time response may state: unknown, general, time."""

LENGTHS = {1: 1.0, 2: 0.3048, 3: 1.0, 4: 0.3048, 5: 1e-3, 6: 1e-2, 7: 0.0254, 8: 1e-3, 10: 1e-3}
"""Units of length by dataset 164's units code [m]; 9 is the user's own."""

IEEE = 2
"""Floating-point format of binary datasets that is read; 1 is DEC's, 3 IBM's."""


def read_uff(path: Path, choices: Choices = SILENT) -> Record:
    """The time responses of a universal file (datasets 58 and 58b; SDRC, revision of 30 June 1999).

    A component is called by node and direction, ``12:+Z``, and answers to ``z`` and to its number as well; a negative
    direction turns its sign. Its unit is the label of the ordinate (m/s, g, …); without one it is of the data type, in
    the unit of length that dataset 164 states, else SI. The abscissa's label is its unit of time. Raises ValueError
    where the file cannot be read, holds no time response or is truncated, and see `clock`.
    """
    existing(path)
    with opened(path) as file:
        with reading(path, " as a universal file"):
            heads, units, notes = _heads(file)
        if not heads:
            raise ValueError(f"ground.file = {path.name!r} holds no time response (dataset 58, function type 1)")
        components = []
        for n, head in heads.items():
            name = f"{head['rsp_node']}:{direction_of(head['rsp_dir'])}"
            axis = DIRECTIONS.get(abs(head["rsp_dir"]))
            load = partial(_load, path, partial(file.read_sets, n), name, units[n], choices)
            components.append(Component(name, load, () if axis is None else (axis,)))
        return record_of(path.name, components, choices, "label its ordinate with the unit", notes)


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """pyuff's view of the file, its ASCII numbers with E as exponent where FORTRAN wrote D."""
    import pyuff

    with tempfile.TemporaryDirectory() as folder:
        with reading(path, " as a universal file"):
            content = path.read_bytes()
            if not content.rstrip(b"\0\x1a \t\r\n").endswith(b"    -1"):
                raise ValueError("its last dataset does not end with -1; the file may be truncated")
            double = re.compile(rb"(?<=[\d.])[Dd](?=[+-]?\d)")
            binary = re.search(rb"^ {4}58b", content, re.MULTILINE | re.IGNORECASE)
            source = path
            if not binary and double.search(content):
                source = Path(folder) / "copy.uff"
                source.write_bytes(double.sub(b"E", content))
            del content
            file = pyuff.UFF(str(source))
        yield file


def _heads(file: Any) -> tuple[dict[int, dict[str, Any]], dict[int, dict[str, Any] | None], list[str]]:
    """Headers of time responses by their place in the file, the units (dataset 164) before each, and remarks."""
    heads, before, notes = {}, {}, []
    units: dict[str, Any] | None = None
    for n, kind in enumerate(file.get_set_types()):
        if int(kind) == 164:
            units = file.read_sets(n)
        if int(kind) != 58:
            continue
        try:
            head = file.read_sets(n, header_only=True)
        except Exception:  # pyuff raises Exception itself
            notes.append(f"dataset {n + 1}, a 58, has a header that cannot be read: it is passed over")
            continue
        if head["func_type"] == TIME_RESPONSE:
            heads[n], before[n] = head, units
    return heads, before, notes


def sets_of(file: Any, kinds: Collection[int]) -> dict[int, dict[str, Any]]:
    """Headers of the datasets 58 of some function types, by their place in the file; what cannot be read is not one."""
    found = {}
    for n, kind in enumerate(file.get_set_types()):
        if int(kind) == 58:
            with suppress(Exception):  # pyuff raises Exception itself
                head = file.read_sets(n, header_only=True)
                if int(head["func_type"]) in kinds:
                    found[n] = head
    return found


def direction_of(number: int) -> str:
    """A direction as components have it: ``+Z``."""
    axis = DIRECTIONS.get(abs(number))
    return str(number) if axis is None else f"{'-' if number < 0 else '+'}{axis.upper()}"


def _load(
    path: Path, read: Callable[[], dict[str, Any]], name: str, units: dict[str, Any] | None, choices: Choices
) -> Loaded:
    """One time response; raises ValueError where it is not what it says."""
    where = f"ground.file = {path.name!r}: {name}"
    with reading(path, f" as a universal file: {name}"):
        content = read()
    if abs(content["rsp_dir"]) in (4, 5, 6):
        raise ValueError(f"{where} is a rotation (direction {content['rsp_dir']}); leave it out of ground.axes")
    if "data" not in content:
        raise ValueError(f"{where} is of ordinate data type {content['ord_data_type']}; known are 2 and 4")
    samples, stated = np.asarray(content["data"]), int(content["num_pts"])
    if np.iscomplexobj(samples):
        raise ValueError(f"{where} is complex; a time response must be real")
    if content["binary"] and content["fp_format"] != IEEE:
        raise ValueError(f"{where} is in floating-point format {content['fp_format']}; only IEEE 754 (2) is read")
    if samples.size < stated:
        raise ValueError(f"{where} holds {samples.size} of {stated} samples; the file may be truncated")
    if samples.size > stated:  # as when numbers of 8 bytes are declared as 4
        raise ValueError(f"{where} holds {samples.size} samples where it states {stated}; export it as ASCII (58)")
    size, remarks = _time_unit(content, name, where)
    holds, remark = _unit(content, name, units, choices)
    samples = -samples if content["rsp_dir"] < 0 else samples
    if content["abscissa_spacing"] == 1:
        begin, step = content["abscissa_min"], content["abscissa_inc"]
        if not 0 < step * size < np.inf or not np.isfinite(begin):
            raise ValueError(f"{where}: its abscissa starts at {begin:g} in steps of {step:g}; times must rise")
        return Loaded(samples, _whole(step, size), holds, begin * size, notes=(*remarks, *remark))
    time = size * np.asarray(content["x"], float)
    rate, index, gaps = clock(time, path.name, choices.gaps, size * _rounding(content))
    return Loaded(on_grid(index, samples), rate, holds, float(time[0]), notes=(*gaps, *remarks, *remark))


def _rounding(content: dict[str, Any]) -> float:
    """What uneven abscissas are rounded to: six digits in ASCII, else as their kind of number."""
    largest = float(np.abs(content["x"]).max(initial=0.0))
    if not np.isfinite(largest) or largest == 0.0:
        return 0.0
    if not content["binary"]:
        return float(10.0 ** (np.floor(np.log10(largest)) - 5.0))
    return float(np.spacing(np.float32(largest))) if content["ord_data_type"] == 2 else 0.0


def _whole(step: float, size: float) -> float:
    """Rate [Hz] of a step that the format rounds to six digits: a whole number of Hz where one is rounded to it."""
    rate = 1.0 / (step * size)
    whole = round(rate)
    return float(whole) if whole and f"{1.0 / (whole * size):.5e}" == f"{step:.5e}" else rate


def label_of(content: dict[str, Any], axis: str) -> str:
    """The label of an axis's units, or what stands in brackets behind the axis's own label."""
    units, label = (str(content.get(f"{axis}_axis_{kind}") or "") for kind in ("units_lab", "lab"))
    bracket = re.search(r"[\[(](.+)[\])]\s*$", label)
    return units if not is_silent(units) or bracket is None else bracket[1]


def _time_unit(content: dict[str, Any], name: str, where: str) -> tuple[float, list[str]]:
    """SI value of the abscissa's unit [s], and a remark where none is stated."""
    kind, label = int(content["abscissa_spec_data_type"]), label_of(content, "abscissa")
    if kind not in TIME_TYPES:
        raise ValueError(f"{where}: its abscissa is of data type {kind}, not of time (17)")
    if is_silent(label):
        return 1.0, [f"{name} has no unit on its abscissa: taken as s, as a time response has it"]
    try:
        return time_unit(label), []
    except ValueError as error:
        raise ValueError(f"{where}: the unit of its abscissa: {error}; label it s or ms") from None


def _unit(
    content: dict[str, Any], name: str, units: dict[str, Any] | None, choices: Choices
) -> tuple[str | tuple[Quantity, float] | None, list[str]]:
    """The ordinate's unit as `record_of` takes it, and a remark where it is not written beside it."""
    holds, label = DATA_TYPES.get(int(content["ordinate_spec_data_type"])), label_of(content, "ordinate")
    if not is_silent(label):
        known = kind_of(label)  # what is unknown is refused by record_of, in its words
        if holds is not None and known in DATA_TYPES.values() and known != holds:
            raise ValueError(f"ground.file: UFF component {name} is {holds} by its data type, but in {label!r}")
        return label, []
    if choices.unit is not None:
        return None, []
    length, words = _length(units, name)
    if holds is None and choices.quantity != "auto":
        return (choices.quantity, length), [f"{name} has no unit label: taken in {words}"]
    if holds is None:
        return None, []
    return (holds, length), [f"{name} has no unit label: taken as its data type ({holds}) has it, in {words}"]


def _length(units: dict[str, Any] | None, name: str) -> tuple[float, str]:
    """The file's unit of length [m], and words for it; dataset 164 says by what lengths are divided to be SI."""
    if units is None:
        return 1.0, "SI"
    factor, code, words = float(units["length"]), int(units["units_code"]), str(units["units_description"]).strip()
    expected = LENGTHS.get(code)
    if code == 9:
        try:
            expected = motion_unit(words)[1]
        except ValueError:
            expected = None
    if not 0 < factor < np.inf or (expected is not None and abs(expected * factor - 1.0) > 1e-3):
        raise ValueError(
            f"ground.file: UFF component {name} has no unit label, and dataset 164 contradicts itself: units code "
            f"{code} ({words or 'no description'}), length factor {factor:g}; say which with ground.unit"
        )
    return 1.0 / factor, f"the length of {1.0 / factor:g} m that dataset 164 states"

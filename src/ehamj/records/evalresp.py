"""Responses by stages, through ObsPy and evalresp, which hear of SI units only."""

import copy
import os
import sys
import tempfile
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from itertools import pairwise
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from ehamj.arrays import ComplexArray
from ehamj.records.instrument import DISAGREEMENT, Instrument
from ehamj.records.said import one_line, warned
from ehamj.records.units import Quantity, motion_unit, unit
from ehamj.signals import Array

if TYPE_CHECKING:
    from obspy.core.inventory import Response

OUTPUTS: dict[Quantity, tuple[str, str]] = {
    "displacement": ("M", "DISP"),
    "velocity": ("M/S", "VEL"),
    "acceleration": ("M/S**2", "ACC"),
}
"""What an instrument senses: the unit as evalresp spells it, and what ObsPy calls the output."""

_LOCK = threading.Lock()
"""evalresp keeps state of its own, and the process has one stream of errors."""

PROBES = np.geomspace(0.01, 1.0, 20)
"""Shares of the Nyquist frequency at which a response is tried, for what ObsPy and evalresp have to say of it."""


def instrument_of(name: str, found: "Response", rate: float, whole_numbers: bool) -> Instrument:
    """The instrument of channel ``name``, sampled at ``rate`` [Hz], from its metadata.

    Samples that are ``whole_numbers`` are counts; others may be volts, where the metadata end in volts.

    Units are taken off here: the stages that evalresp sees sense SI. Raises ValueError, naming channel and unit, where
    it senses no motion that is known, does not end in counts, or cannot be evaluated.
    """
    overall, stages = found.instrument_sensitivity, sorted(found.response_stages, key=_number)
    whole = None if overall is None or not overall.value else overall
    first = next((str(part.input_units) for part in (*stages[:1], overall) if part and part.input_units), "")
    last = next((str(part.output_units) for part in (*stages[-1:], overall) if part and part.output_units), "")
    if not stages and whole is None:
        raise ValueError(f"ground.inventory: the metadata of {name} have neither stages nor an overall sensitivity")
    quantity, size = _sensed(name, first)
    notes = list(_counted(name, last, whole_numbers))
    stated = None
    if whole is not None:
        ours = (quantity, size) if not whole.input_units else _sensed(name, str(whole.input_units))
        if ours[0] != quantity:
            raise ValueError(
                f"ground.inventory: the stages of {name} sense {first!r}, but its overall sensitivity is per "
                f"{whole.input_units!r}; correct the metadata"
            )
        stated = float(whole.value) / ours[1]
    if not stages:
        return Instrument(quantity, None, None, stated, (first, size), notes=tuple(notes))
    _check_chain(name, stages)
    plain, band = _plain(found, stages, quantity), _listed(stages)

    def evaluate(frequency: Array) -> ComplexArray:
        return _evaluated(name, plain, frequency, quantity, band)[0] / size

    said = _evaluated(name, plain, PROBES * rate / 2, quantity, band)[1]
    notes += [f"{name}: of its response ObsPy says: {text}" for text in said]
    if band is not None:
        notes.append(
            f"{name}: its response is listed from {band[0]:g} to {band[1]:g} Hz; what lies outside is left out"
        )
    at = None if whole is None or whole.frequency is None else float(whole.frequency)
    product = None if at is None else float(abs(evaluate(np.array([at]))[0]))
    if whole is not None and stated is not None:
        if not product:
            notes.append(f"{name}: its overall sensitivity holds at {at} Hz, where its stages give nothing to compare")
        elif _apart(stated, product) and not _apart(float(whole.value), product):
            # ObsPy writes it so: it counts stages per stated unit, and their overall sensitivity per SI unit.
            stated = float(whole.value)
            notes.append(
                f"{name}: its overall sensitivity is taken per SI unit, not per {whole.input_units!r}: so it agrees"
            )
    where = f" at {at:g} Hz" if at is not None else ""
    return Instrument(quantity, evaluate, product, stated, (first, size), where, tuple(notes))


def _apart(one: float, other: float) -> bool:
    return abs(np.log(abs(one / other))) > np.log1p(DISAGREEMENT)


def _number(stage: object) -> int:
    return int(getattr(stage, "stage_sequence_number", 0))


def _sensed(name: str, units: str) -> tuple[Quantity, float]:
    try:
        return motion_unit(units.split(" - ")[0])
    except ValueError as error:
        raise ValueError(f"ground.inventory: {name} senses {units!r}: {error}") from None


def _counted(name: str, units: str, whole_numbers: bool) -> Iterator[str]:
    """A remark where it is not clear that the last stage gives what the samples are; raises ValueError where not."""
    try:
        kind = unit(units.split(" - ")[0]).kind if units else None
    except ValueError:
        kind = "counts" if "count" in units.lower() else None
    if kind is None:
        yield f"{name}: its metadata do not say that the response ends in counts ({units!r}); taken as counts"
    elif kind == "voltage" and not whole_numbers and unit(units.split(" - ")[0]).size == 1.0:
        yield f"{name}: its response ends in volts, so that its samples are taken as volts"
    elif kind != "counts":
        raise ValueError(
            f"ground.inventory: the response of {name} ends in {units!r}, not in counts: a stage is missing. Complete "
            "it, or set ground.remove_response = false and ground.unit"
        )


def _check_chain(name: str, stages: list[object]) -> None:
    """Raise ValueError where a stage takes another unit than the one before gives."""
    for one, other in pairwise(stages):
        given, taken = str(one.output_units or ""), str(other.input_units or "")  # type: ignore[attr-defined]
        try:
            apart = given and taken and unit(given) != unit(taken)
        except ValueError:
            continue  # what lies between the stages need not be known, where both spell it the same
        if apart:
            raise ValueError(
                f"ground.inventory: stage {_number(one)} of {name} gives {given!r}, and the next takes {taken!r}; "
                "correct the metadata"
            )


def _plain(found: "Response", stages: list[object], quantity: Quantity) -> "Response":
    """A copy whose stages lead from SI over volts to counts, so that evalresp has nothing to convert."""
    plain = copy.deepcopy(found)
    plain.instrument_sensitivity = None  # held against the stages by `agreed_response`
    ordered = sorted(plain.response_stages, key=_number)
    for k, stage in enumerate(ordered):
        stage.input_units = OUTPUTS[quantity][0] if k == 0 else "V"
        stage.output_units = "COUNTS" if k == len(ordered) - 1 else "V"
        if stage.stage_gain is not None and stage.stage_gain_frequency is None:
            # ObsPy passes over a gain without frequency.
            stage.stage_gain_frequency = getattr(stage, "normalization_frequency", 0.0)
    return plain


def _listed(stages: list[object]) -> tuple[float, float] | None:
    """Band of the stages that list their response [Hz]; ObsPy extrapolates it as it comes."""
    lists = [
        [float(e.frequency) for e in elements]
        for s in stages
        if (elements := getattr(s, "response_list_elements", None))
    ]
    return (max(map(min, lists)), min(map(max, lists))) if lists else None


def _evaluated(
    name: str, found: "Response", frequency: Array, quantity: Quantity, band: tuple[float, float] | None
) -> tuple[ComplexArray, list[str]]:
    """Response at frequencies [Hz] and what was said of it; zero outside the band of a list."""
    inside = np.ones(frequency.shape, bool) if band is None else (frequency >= band[0]) & (frequency <= band[1])
    values, failure = np.zeros(frequency.shape, complex), None
    with _LOCK, warnings.catch_warnings(record=True) as caught, _overheard() as printed:
        warnings.simplefilter("always")
        _import_plainly()
        try:
            if inside.any():
                output = OUTPUTS[quantity][1]
                values[inside] = found.get_evalresp_response_for_frequencies(frequency[inside], output=output)
        except Exception as error:  # evalresp raises what it likes
            failure = error
    if failure is not None:
        why = "; ".join([one_line(failure), *printed])
        raise ValueError(f"ground.inventory: the response of {name} cannot be evaluated: {why}") from failure
    if not np.isfinite(values).all():
        raise ValueError(f"ground.inventory: the response of {name} is not finite at some frequencies")
    if inside.all() and not values.any() and (frequency > 0).any():
        raise ValueError(f"ground.inventory: the response of {name} is zero at all frequencies")
    return values, list(dict.fromkeys([*warned(caught), *printed]))


def _import_plainly() -> None:
    """Import ObsPy's package with evalresp without what draws spectra, which takes longer than all else of a record.

    Who asks the package for that later gets it.
    """
    if "obspy.signal" in sys.modules:
        return
    drawing = "obspy.signal.spectral_estimation"
    sys.modules[drawing] = ModuleType(drawing)
    sys.modules[drawing].__dict__["PPSD"] = None
    try:
        package = import_module("obspy.signal")
    finally:
        del sys.modules[drawing]

    def asked(name: str) -> Any:
        if name != "PPSD":
            raise AttributeError(f"module {package.__name__!r} has no attribute {name!r}")
        return import_module(drawing).PPSD

    package.__dict__.pop("PPSD", None)
    package.__dict__["__getattr__"] = asked


@contextmanager
def _overheard() -> Iterator[list[str]]:
    """What C code prints as errors, which Python's warnings do not see; other output is passed on."""
    heard: list[str] = []
    sys.stderr.flush()
    with tempfile.TemporaryFile() as sink:
        real = os.dup(2)
        os.dup2(sink.fileno(), 2)
        try:
            yield heard
        finally:
            os.dup2(real, 2)
            os.close(real)
            sink.seek(0)
            for line in sink.read().decode(errors="replace").splitlines(keepends=True):
                if "WARNING" in line or "EVRESP" in line or "Note:" in line:
                    heard.append(one_line(line))
                elif heard and line.startswith("\t"):  # goes on with what was said
                    heard[-1] += " " + one_line(line)
                else:
                    os.write(2, line.encode())

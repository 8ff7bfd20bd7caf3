"""The figures of an identification."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.campaign.names import axis_of, short_names
from ehamj.pages.words import DASH, ENGINEERING, number
from ehamj.plots import BLUE, GREY, VERMILLION, Figure, Line, Response, lines_chart, response
from ehamj.plots.beside import Beside, beside_chart, spectra_chart
from ehamj.plots.intervals import Interval, intervals_chart
from ehamj.plots.squares import squares_chart
from ehamj.studies.outcome import Drawing

if TYPE_CHECKING:
    from ehamj.identification.outcome import ChannelFit, Identification, Identified, TestFit

INTERVAL: Final = 1.96
"""Deviations to the ends of a 95 % interval."""
CIRCLE: Final = float(np.sqrt(np.log(20.0)))
"""Radius of the circle that a complex value is in with 95 %, over √E|error|²."""
PANELS: Final = 6
"""Channels of a test that are drawn, those first that fit least."""
WINDOW: Final = (200, 800)
"""Samples that are drawn of a record: a tenth of it, within these."""
SEGMENT: Final = 1024
"""Longest segment of a spectrum [samples]."""
FEW: Final = 16
"""Samples of a record from which on there is a spectrum."""
LINES: Final = 8
"""Channels whose autocorrelation is drawn."""


def value_drawings(found: "Identification") -> Iterator[tuple[str, Drawing]]:
    """Values beside where they began, and how they go together."""
    names = short_names(found.values)
    caption = (
        "Each value over the one at which the fit began, in per cent of that (where that is 0, of half "
        "of its bounds' distance), within the bounds in which it was looked for; at the right its standard deviation."
    )
    yield "values", Drawing(caption, lambda: _values_chart(found, names))
    told = [k for k, one in enumerate(found.values.values()) if one.value is not None]
    if len(told) > 1:
        caption = (
            "Correlations of the values' errors: near ±1 the data tell a combination of two much better than each; a "
            "test that moves them apart helps both."
        )
        yield "correlation", Drawing(caption, partial(_correlation_chart, found, list(names.values()), told))
    for key, profile in found.profiles.items():
        caption = (
            "Rise of −2·log likelihood with this value held and all others fitted again. Where it stays below 3.84 "
            "the value goes with the data (95 %)."
        )
        yield f"profile {key}", Drawing(caption, partial(_profile_chart, names[key], found.values[key], profile))


def _values_chart(found: "Identification", names: dict[str, str]) -> Figure:
    rows = []
    for key, one in found.values.items():
        low, high = off(one, one.bounds[0]), off(one, one.bounds[1])
        if one.value is None:
            rows.append(Interval(names[key], None, 0.0, 0.0, (low, high), DASH))
            continue
        reach = INTERVAL * (one.deviation or 0.0)
        ends = max(off(one, one.value - reach), low), min(off(one, one.value + reach), high)
        said = "" if one.deviation is None else f"± {number(100.0 * one.deviation / size_of(one), 2)} %"
        rows.append(Interval(names[key], off(one, one.value), *ends, (low, high), said))
    return intervals_chart("Values", "off the value at the start [%]", rows)


def off(one: "Identified", value: float) -> float:
    """How far a value is off the start [%]."""
    return 100.0 * (value - one.start) / size_of(one)


def size_of(one: "Identified") -> float:
    """What a value's changes are shares of: its start, or half of the bounds' distance where that is far less."""
    half = 0.5 * (one.bounds[1] - one.bounds[0])
    return abs(one.start) if abs(one.start) > 0.05 * half else half


def _correlation_chart(found: "Identification", names: list[str], told: list[int]) -> Figure:
    rows = [f"{names[k]}  {place}" for place, k in enumerate(told, 1)]
    columns = [str(place) for place in range(1, len(told) + 1)]
    return squares_chart("Correlations", rows, columns, found.correlation[np.ix_(told, told)])


def _profile_chart(name: str, one: "Identified", profile: Array) -> Figure:
    axis, values = axis_of(name, one.unit, profile[:, 0])
    limit = Line("95 %", values[[0, -1]], [3.84, 3.84], GREY, 1, width=1.0)
    rise = Line("all others fitted", values, profile[:, 1])
    return lines_chart(f"Profile: {name}", axis, {"rise of −2·log likelihood [-]": [rise, limit]})


def drawings_of_test(test: "TestFit", held_out: bool = False) -> Iterator[tuple[str, Drawing]]:
    """A test's channels measured beside predicted, and what is left."""
    yield from _time_drawings(test)
    responses = [one for one in test.channels if np.iscomplexobj(one.measured) and one.axis == "frequency"]
    for one in least(responses):
        caption = "What was measured with its 95 % confidence and its coherence, and the linear model."
        yield f"{test.name}: {one.name}", Drawing(caption, partial(_response_chart, test, one))
    judged = [one for one in least(test.channels, LINES) if one.whiteness is not None]
    if judged and not held_out:
        caption = (
            "Autocorrelation of the errors, what their noise model explains taken out. Of white ones 99 % stay between "
            "the dotted lines; more means that the model misses a part."
        )
        yield f"{test.name}: errors", Drawing(caption, partial(_whiteness_chart, test, judged))
    if "after" in test.found:
        caption = (
            "Likeness (MAC) of measured shapes and the identified model's: 1 where they are the same but for size."
        )
        yield f"{test.name}: shapes", Drawing(caption, partial(_shapes_chart, test))


def _time_drawings(test: "TestFit") -> Iterator[tuple[str, Drawing]]:
    records = [one for one in test.channels if one.axis == "time" and len(one.at) > 1]
    if not records:
        return
    shown = least(records)
    few = f"The {len(shown)} of {len(records)} channels that fit least. " if len(shown) < len(records) else ""
    caption = f"{few}The liveliest part of the record; below each channel what is left, at its own scale."
    yield f"{test.name}: time", Drawing(caption, partial(_time_chart, test, shown))
    if len(records[0].at) >= FEW:
        caption = f"{few}Spectral densities of all that was compared."
        yield f"{test.name}: spectra", Drawing(caption, partial(_spectra_chart, test, shown))


def least(channels: "Sequence[ChannelFit]", most: int = PANELS) -> "list[ChannelFit]":
    """Those channels that fit least, in their order."""
    worst = sorted(channels, key=lambda one: (not np.isnan(one.fit), one.fit))[:most]
    return [one for one in channels if any(one is other for other in worst)]


def reading(unit: str) -> tuple[float, str]:
    """Factor to the unit in which a channel is read, and what that is called."""
    return ENGINEERING.get(unit.replace("²", "^2").replace("³", "^3"), (1.0, "-" if unit in ("", "1") else unit))


def _time_chart(test: "TestFit", channels: "Sequence[ChannelFit]") -> Figure:
    part = liveliest(channels)
    shown = []
    for one in channels:
        factor, unit = reading(one.unit)
        own = slice(*np.searchsorted(one.at, part)) if len(one.at) else slice(0)
        noise = factor * float(np.sqrt(np.mean(one.deviation**2)))
        measured, predicted = (factor * np.real(values[own]) for values in (one.measured, one.predicted))
        shown.append(Beside(one.name, unit, one.at[own], measured, predicted, noise, fit_words(one)))
    return beside_chart(f"{test.name}: measured beside model", "time [s]", shown)


def liveliest(channels: "Sequence[ChannelFit]") -> tuple[float, float]:
    """From when to when a part of a record goes in which most happens, in all its channels [s]."""
    time = channels[0].at
    size = int(np.clip(len(time) // 10, *WINDOW))
    if len(time) <= size:
        return float(time[0]), float(time[-1]) * (1.0 + 1e-12) + 1e-12
    power = np.zeros(len(time) - 1)
    for one in channels:
        if len(one.at) == len(time):
            steps = np.diff(np.real(one.measured)) ** 2
            power += steps / (steps.mean() or 1.0)
    total = np.concatenate([[0.0], np.cumsum(power)])
    first = int(np.argmax(total[size:] - total[:-size]))
    return float(time[first]), float(time[first + size])


def _spectra_chart(test: "TestFit", channels: "Sequence[ChannelFit]") -> Figure:
    from scipy.signal import welch

    shown = []
    for one in channels:
        factor, unit = reading(one.unit)
        rate, segment = 1.0 / float(np.mean(np.diff(one.at))), min(len(one.at), SEGMENT)
        parts = []
        for values in (one.measured, one.predicted, one.measured - one.predicted):
            hertz, power = welch(factor * np.real(values), rate, nperseg=segment)
            parts.append(np.maximum(np.sqrt(power[1:]), 1e-300))
        measured, predicted, left = parts
        shown.append(Beside(one.name, f"{unit}/√Hz", hertz[1:], measured, predicted, left, fit_words(one)))
    return spectra_chart(f"{test.name}: spectra", shown)


def _response_chart(test: "TestFit", one: "ChannelFit") -> Figure:
    coherence = np.full(one.at.shape, np.nan) if one.coherence is None else one.coherence
    curves = [
        Response("model", one.at, np.asarray(one.predicted, complex), BLUE),
        Response("measured", one.at, np.asarray(one.measured, complex), VERMILLION, CIRCLE * one.deviation,
                 coherence, coherence),
    ]  # fmt: skip
    return response(f"{test.name}: {one.name}", curves, one.unit or "1")


def _whiteness_chart(test: "TestFit", channels: "Sequence[ChannelFit]") -> Figure:
    lines = []
    for place, one in enumerate(channels):
        own = one.whiteness
        assert own is not None
        lags = np.arange(1, len(own.correlation))
        lines.append(Line(one.name, lags, own.correlation[1:], place, place // 2, width=1.2))
        if place == 0:
            ends = [0, lags[-1]]
            lines += [Line("", ends, [sign * own.limit] * 2, GREY, 2, width=1.2) for sign in (1.0, -1.0)]
    largest = max(float(np.abs(line.y).max(initial=0.0)) for line in lines)
    axis = "autocorrelation [-]"
    reach = max(0.2, 1.1 * largest)
    return lines_chart(f"{test.name}: what is left", "lag [samples]", {axis: lines}, limits={axis: (-reach, reach)})


def _shapes_chart(test: "TestFit") -> Figure:
    mac = test.found["after"]["mac"]
    values = [[np.nan if value is None else value for value in row] for row in mac["values"]]
    return squares_chart(f"{test.name}: shapes", mac["measured"], mac["computed"], values, signed=False)


def fit_words(one: "ChannelFit") -> str:
    """How well a channel fits, in a few words."""
    return "" if np.isnan(one.fit) else f"fit {number(one.fit)} %"

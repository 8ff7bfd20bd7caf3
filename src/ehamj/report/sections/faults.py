"""What failed in the course of a run, and what it made of the machine: before, while it settled, and after."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final

from ehamj import plots
from ehamj.judge.decisive import place_in_words
from ehamj.judge.faults import NOTHING, FaultFound, Phase
from ehamj.judge.levels import ByBand
from ehamj.pages import Picture, Section, Table
from ehamj.pages.words import BAR, MICRO, decibel, measured, number, scaled
from ehamj.plots import Levels
from ehamj.report.levels import HEADLINE_BANDS
from ehamj.report.shown import Shown

PHASES: Final = {"before": "before", "during": "while it settles", "after": "after"}
LINEAR: Final = "after, linear"
EXPECTED_COLOR: Final = "#111827"

NOTE: Final = (
    "The law is that of the intact machine. Before and after are judged as runs by themselves, by the RMS over each "
    "part; while a fault settles, the largest sliding second counts, from one second before it on. Linear: the "
    "linear machine with the fault, settled, on the floor of the part after it, or of the run so far where nothing has "
    "settled; it has neither noise nor limits."
)


def faults(shown: Shown) -> Section | None:
    """Of each result that had any."""
    struck = {label: result.summary.fault for label, result in shown.results.items() if result.summary.fault}
    if not struck:
        return None
    figures: list[Picture] = []
    tables: list[Table] = []
    notes: list[str] = []
    front = in_front(shown)
    for label, found in struck.items():
        whose = "" if shown.alone else f"{label}, "
        end = shown.results[label].summary.timing.simulated_s
        for one in found:
            words = f"{whose}{one.in_words()}"
            if one.idle:
                notes.append(f"{words[0].upper()}{words[1:]}: {NOTHING}.")
                continue
            figures += [] if one is front or not _curves(one, "") else [picture(shown, label, one)]
            tables += _tables(words, one, end)
    return Section("faults", "Faults", figures, tables, [NOTE, *notes] if tables else notes, tables_first=True)


def in_front(shown: Shown) -> FaultFound | None:
    """The fault of the first result whose figure stands in front: the last of which there is one."""
    return next((one for one in reversed(shown.first.summary.broken) if _curves(one, "")), None)


def picture(shown: Shown, label: str, one: FaultFound) -> Picture:
    """Vertical attenuation before and after a fault of a result, and what was to be expected after."""
    whose = "" if shown.alone else f"{label}, "
    title = f"Vertical attenuation, {whose}fault at {one.where}"
    number_of = 1 + next(k for k, other in enumerate(shown.results[label].summary.fault) if other is one)
    figure = plots.attenuation(title, _curves(one, shown.colors[label]))
    settled = "" if one.after else " The run had not settled after it."
    return Picture(f"fault-{label}-{number_of}", figure, f"At {one.time_s:.4g} s {one.what}.{settled}")


def _curves(one: FaultFound, color: str) -> list[Levels]:
    curves = [
        Levels.of_bands(f"{words}, run", phase.attenuation_db, own)
        for words, phase, own in (("before", one.before, plots.GREY), ("after", one.after, color))
        if phase is not None
    ]
    if one.expected is not None and one.expected.attenuation_db:
        name = LINEAR if one.after else f"{LINEAR} (run not settled)"
        linear = Levels.of_bands(name, one.expected.attenuation_db, EXPECTED_COLOR)
        curves.append(replace(linear, dash="--"))
    return curves


def _tables(title: str, one: FaultFound, end: float) -> Iterator[Table]:
    """What each part of the run that there is came to: in words, and in numbers; the run ended at a time [s]."""
    phases: dict[str, Phase] = {name: own for name in PHASES if (own := getattr(one, name)) is not None}
    head = ["", *(f"{PHASES[name]}, {own.from_s:.4g} to {own.to_s:.4g} s" for name, own in phases.items())]
    judged = next((tuple(phase.criterion.verdict) for phase in phases.values()), ())
    classes = [
        [direction, *(phase.criterion.briefly()[direction] for phase in phases.values())] for direction in judged
    ]
    missing = "" if one.after else f"After: {one.unsettled(end)}."
    if not phases:
        classes = []
    yield Table(f"{title[0].upper()}{title[1:]}: class of the machine", head, classes, missing, kind="words")
    if not phases:
        return
    loop = one.expected
    said = [] if loop is None or loop.stable else [f"The linear loop is unstable: {loop.pole}."]
    said += [f"Readings struck: {', '.join(one.channels)}."] if one.channels else []
    said += [f"{one.note[0].upper()}{one.note[1:]}."] if one.note else []
    title = f"{title[0].upper()}{title[1:]}: in numbers"
    expected = {} if loop is None else loop.attenuation_db
    rows = list(_rows(one, phases, expected))
    yield Table(title, [*head, *([LINEAR] if expected else [])], rows, " ".join(said), kind="numbers wide")


def _rows(one: FaultFound, phases: dict[str, Phase], expected: ByBand) -> Iterator[list[str]]:
    def row(name: str, cell: Callable[[Phase], str], linear: float | None = None) -> list[str]:
        found = [cell(phase) for phase in phases.values()]
        return [name, *found, *(["" if linear is None else decibel(linear)] if expected else [])]

    for band in HEADLINE_BANDS:
        name = f"vertical attenuation of the CG at {band} Hz [dB]"
        yield row(name, lambda phase, b=band: decibel(phase.attenuation_db.get(b)), expected.get(band))  # type: ignore[misc]
    known = next(iter(phases.values()))
    for place in known.peak_velocity:
        words = "floor, worst mount" if place == "floor" else place_in_words(place)
        yield row(
            f"peak vertical velocity, {words} [µm/s]",
            lambda phase, p=place: measured(scaled(phase.peak_velocity[p]["z"], MICRO)),  # type: ignore[misc]
        )
    yield row("largest stroke from rest [µm]", lambda phase: _largest(phase.stroke, MICRO))
    mounts = [one.where] if one.where in known.pressure else list(known.pressure)
    for mount in mounts:
        yield row(
            f"chamber pressures at {mount} [bar]",
            lambda phase, m=mount: f"{_bar(phase, m, 'lowest')} to {_bar(phase, m, 'highest')}",  # type: ignore[misc]
        )
    for limit in known.saturation:
        yield row(
            f"time at a limit, {limit.replace('_', ' ')} [%]",
            lambda phase, name=limit: _largest(phase.saturation[name], 100.0),  # type: ignore[misc]
        )


def _bar(phase: Phase, mount: str, which: str) -> str:
    return number(scaled(getattr(phase.pressure[mount], which), BAR))


def _largest(of_mounts: dict[str, float | None] | dict[str, float], factor: float) -> str:
    """The largest of all mounts, and at which."""
    mount, value = max(of_mounts.items(), key=lambda item: item[1] or 0.0)
    return measured(scaled(value, factor)) + (f" ({mount})" if value else "")

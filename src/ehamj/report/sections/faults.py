"""What failed in the course of a run, and what it made of the machine: before, while it settled, and after."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Final

from ehamj import plots
from ehamj.judge.decisive import place_in_words
from ehamj.judge.faults import FaultFound, Phase
from ehamj.judge.headline import DIRECTIONS
from ehamj.pages import Picture, Section, Table
from ehamj.pages.words import BAR, DASH, MICRO, decibel, measured, number, scaled
from ehamj.plots import Levels
from ehamj.report.sections.headline import HEADLINE_BANDS
from ehamj.report.shown import Shown

PHASES: Final = {"before": "before", "during": "while it settles", "after": "after"}
EXPECTED_COLOR: Final = "#111827"

NOTE: Final = (
    "The law is that of the intact machine. Before and after are judged as runs by themselves, by the RMS over each "
    "part; while a fault settles, the largest sliding second counts, from one second before it on. Linear: the "
    "linear machine with the fault, settled, on the floor of the part after it; it has neither noise nor limits."
)


def faults(shown: Shown) -> Section | None:
    """Of each result that had any."""
    struck = {label: result.summary.fault for label, result in shown.results.items() if result.summary.fault}
    if not struck:
        return None
    figures: list[Picture] = []
    tables: list[Table] = []
    for label, found in struck.items():
        whose = "" if shown.alone else f"{label}, "
        for number_of, one in enumerate(found, 1):
            figures += _picture(f"{label}-{number_of}", f"{whose}{one.where}: {one.what}", one, shown.colors[label])
            tables += _tables(f"{whose}{one.in_words()}", one)
    return Section("faults", "Faults", figures, tables, [NOTE], tables_first=True)


def _picture(name: str, title: str, one: FaultFound, color: str) -> Iterator[Picture]:
    """Vertical attenuation before and after, and what was to be expected after."""
    curves = [
        Levels.of_bands(f"{words}, run", phase.attenuation_db, own)
        for words, phase, own in (("before", one.before, plots.GREY), ("after", one.after, color))
        if phase is not None
    ]
    if one.expected is not None and one.expected.attenuation_db:
        linear = Levels.of_bands("after, linear", one.expected.attenuation_db, EXPECTED_COLOR)
        curves.append(replace(linear, dash="--"))
    if curves:
        figure = plots.attenuation(f"Vertical attenuation, {title}", curves)
        yield Picture(f"fault-{name}", figure, f"At {one.time_s:.4g} s {one.what}.")


def _tables(title: str, one: FaultFound) -> Iterator[Table]:
    """What each part of the run came to: in words, and in numbers."""
    phases: dict[str, Phase | None] = {name: getattr(one, name) for name in PHASES}
    head = ["", *(_when(words, phases[name]) for name, words in PHASES.items())]
    classes = [
        [direction, *(DASH if phase is None else phase.criterion.briefly()[direction] for phase in phases.values())]
        for direction in DIRECTIONS
    ]
    yield Table(f"{title[0].upper()}{title[1:]}: class of the machine", head, classes, kind="words")
    loop = one.expected
    said = [] if loop is None or loop.stable else [f"The linear loop is unstable: {loop.pole}."]
    said += [f"Readings struck: {', '.join(one.channels)}."] if one.channels else []
    said += [f"{one.note[0].upper()}{one.note[1:]}."] if one.note else []
    title = f"{title[0].upper()}{title[1:]}: in numbers"
    yield Table(title, [*head, "after, linear"], list(_rows(one, phases)), " ".join(said), kind="numbers wide")


def _when(words: str, phase: Phase | None) -> str:
    return words if phase is None else f"{words}, {phase.from_s:.4g} to {phase.to_s:.4g} s"


def _rows(one: FaultFound, phases: dict[str, Phase | None]) -> Iterator[list[str]]:
    def row(name: str, cell: Callable[[Phase], str], linear: float | None = None) -> list[str]:
        found = [DASH if phase is None else cell(phase) for phase in phases.values()]
        return [name, *found, "" if linear is None else decibel(linear)]

    expected = {} if one.expected is None else one.expected.attenuation_db
    for band in HEADLINE_BANDS:
        name = f"vertical attenuation of the CG at {band} Hz [dB]"
        yield row(name, lambda phase, b=band: decibel(phase.attenuation_db.get(b)), expected.get(band))  # type: ignore[misc]
    known = next(phase for phase in phases.values() if phase is not None)
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

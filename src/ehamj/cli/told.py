"""What `ehamj run` says at its end: the verdict first, then what it rests on, where it is and what to open next."""

from collections.abc import Mapping, Sequence
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any, Final

from ehamj.cli.printing import print_table, say
from ehamj.judge.attenuation import SHOWN_BANDS
from ehamj.judge.brief import (
    MEAN,
    NAMES,
    PROCESSING,
    learnt_in_words,
    margins_in_words,
    simulated,
)
from ehamj.judge.isolation import WORST_PLACE
from ehamj.judge.summary import Summary
from ehamj.judge.worse import cancelled, made_worse
from ehamj.pages.words import DASH, MICRO, NEGLIGIBLE, number
from ehamj.plant.axes import AXES, DOFS
from ehamj.result import Result
from ehamj.run.limits import binding
from ehamj.run.limits import warnings as reached
from ehamj.scenario.model import Scenario
from ehamj.scenario.variants import known_variants

NOTES: Final = 5
"""Notes that are printed; the others are on the page."""


def print_run(results: Mapping[str, Result], folder: Path, spent: str) -> None:
    """Print how a run went.

    Args:
        results: by the names of their scenarios, its own first, then those of its variants.
        folder: where it is stored.
        spent: where its time went, in words.
    """
    result = next(iter(results.values()))
    summary, scenario = result.summary, result.scenario
    state = "complete" if summary.complete else "INCOMPLETE"
    say(f"{simulated(summary)}, {state}", f"{summary.name}: ")
    if summary.complete:
        _print_verdict(summary)
        _print_attenuation(results, scenario)
        _print_means(summary, scenario)
        if summary.peak:
            _print_motion(summary, scenario.plant.mounts[0])
    else:
        say(f"{summary.failure}")
        say("nothing is judged; histories, report and replay show what led there")
    _print_notes(
        summary, scenario, "on the page" if (folder / "report.html").is_file() else f"in {folder / 'summary.json'}"
    )
    say(spent, "time: ")
    _print_next(folder, scenario)


def _print_verdict(summary: Summary) -> None:
    """Classes of each direction, and where the machine is worse than its floor."""
    lines = summary.lines(short=True)
    by = lines.pop("judged by", "")
    say(f" by {by}" if by else "", "\nvibration class")
    for direction, said in lines.items():
        say(said, f"  {direction}: ")
    if worse := made_worse(summary.worse):
        say(worse, "  worse than its floor: ")
    say("")


def _print_attenuation(results: Mapping[str, Result], scenario: Scenario) -> None:
    """Attenuation of each motion in the bands that are known, of the variants at their worst places."""
    own = next(iter(results.values())).summary
    labels = {full: name for full, name in known_variants(scenario).items() if name in scenario.compare}
    rows: list[tuple[str, str, Mapping[str, float | None]]] = []
    for motion, places in own.attenuation_first().items():
        name = NAMES.get(motion, f"along {motion}")
        rows += [(name, place, levels) for place, levels in places.items()]
        for other, result in results.items():
            beside = result.summary.attenuation_first().get(motion, {}) if other in labels else {}
            if result.complete and (levels := beside.get(WORST_PLACE)):
                rows.append((name, f"{WORST_PLACE}, {labels[other]}", levels))
    bands = [band for band in SHOWN_BANDS if any(levels.get(band) is not None for *_, levels in rows)]
    if not bands:
        say("attenuation, floor to machine: undecided in every band; see the notes")
        return
    cells = [(name, place, *(_decibel(levels.get(band)) for band in bands)) for name, place, levels in rows]
    mixed = f" ({own.mixed})" if own.mixed else ""
    heads = ("motion", "of the machine", *(f"{band} Hz" for band in bands))
    print_table(f"attenuation, floor to machine{mixed} [dB]", heads, cells)
    if any(set(SHOWN_BANDS).intersection(cancelled(own, axis)) for axis in AXES):
        say(MEAN)


def _decibel(level: float | None) -> str:
    return DASH if level is None else f"{round(level)}".replace("-", "−")  # round has no minus zero


def _print_means(summary: Summary, scenario: Scenario) -> None:
    """By what it got there: limits, the law and its margins, what was learnt and followed."""
    if limits := binding(summary, scenario.plant):
        say(limits, "limits: ")
    if summary.law is not None:
        say(summary.law.words, "law: ")
    if summary.margins is not None:
        say(margins_in_words(summary), "margins: ")
    if summary.followed:
        say(", ".join(line.words for line in summary.followed), "lines: ")
    for mount, told in summary.learnt.items():
        say(learnt_in_words(told), f"learnt, {mount}: ")
    say("")


def _print_motion(summary: Summary, mount: str) -> None:
    """Peaks and RMS values of floor and machine and of a stroke, those that are not rounding."""
    wanted: list[tuple[str, str, tuple[str, ...], tuple[str, ...]]] = [
        (f"velocity {axis}", "µm/s", ("ground_velocity", mount, axis), ("cg_velocity", axis)) for axis in "zxy"
    ]
    wanted += [(f"rotation {dof}", "µrad", (), ("machine_displacement", dof)) for dof in DOFS[len(AXES) :]]
    wanted += [(f"stroke ({mount})", "µm", (), ("stroke", mount))]
    rows = []
    for name, unit, floor, machine in wanted:
        beside = _levels(summary, floor) if floor else []
        levels = _levels(summary, machine)
        if any(level is None or level >= NEGLIGIBLE for level in (*beside, *levels)):
            rows.append((name, unit, *(map(number, beside) if floor else ("", "")), *map(number, levels)))
    heads = ("motion about equilibrium", "unit", "floor\npeak", "floor\nRMS", "machine\npeak", "machine\nRMS")
    print_table(f"floor at mount {mount}, machine at its centre of gravity", heads, rows)


def _levels(summary: Summary, keys: Sequence[str]) -> list[float | None]:
    """Peak and RMS in millionths, None where one is not known."""
    levels: list[Any] = [reduce(getitem, keys, table) for table in (summary.peak, summary.rms)]
    return [None if level is None else MICRO * level for level in levels]


def _print_notes(summary: Summary, scenario: Scenario, more: str) -> None:
    """What a reader must know: neither what was said above, nor how a record was processed."""
    said = {*(one.in_words() for one in summary.worse if one.made_worse), *reached(summary.saturation)}
    left = [text for text in summary.warnings if text not in said and not PROCESSING.match(text)]
    if (scale := getattr(scenario.ground, "scale", 1.0)) != 1.0:
        by = ", ".join(f"{own:g} ({name})" for name, own in scale.items()) if isinstance(scale, dict) else f"{scale:g}"
        way_out = "as the scenario states; --set ground.scale=1 takes a record as it is"
        say(f"the recorded floor is scaled by {by} (ground.scale), {way_out}", "note: ")
    for text in left[:NOTES]:
        say(text, "note: ")
    if hidden := len([text for text in summary.warnings if text not in said]) - len(left[:NOTES]):
        say(f"and {hidden} more {more}", "notes: " if not left else "")


def _print_next(folder: Path, scenario: "Scenario") -> None:
    """Where it is, and what to open next."""
    say(f"{folder}", "result: ", whole=True)
    there = {name: (folder / f"{name}.{ending}").is_file() for name, ending in (("report", "html"), ("replay", "rrd"))}
    if there["report"]:
        say(f"{folder / 'report.html'}", "read: ", whole=True)
    if there["replay"]:
        say(f"ehamj replay {folder}", "watch: ", whole=True)
    for name in [name for name, is_there in there.items() if not is_there]:
        way = f"`ehamj {name} {folder}` writes it"
        if scenario.output.channels != ("*",):
            way = f"of what output.channels leaves, `ehamj {name} {folder}` may not make it"
        say(f"none; {way}", f"{name}: ", whole=True)

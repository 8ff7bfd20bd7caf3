"""The control loop: its gain as Bode, Nyquist and Nichols plots, and the margins that it leaves."""

from collections.abc import Iterator, Mapping
from typing import Final, TypeVar

from ehamj import plots
from ehamj.judge.learnt import UNITS
from ehamj.judge.summary import LoopMargins, PlaceMargins
from ehamj.pages import Picture, Section, Table
from ehamj.pages.words import DASH, number
from ehamj.report.shown import Shown

LOOP_HEAD: Final = ("loop", "gain [dB]", "phase [°]", "disk [-]", "peak [-]", "peak at [Hz]", "crosses at [Hz]")
ASKED: Final = 0.5
"""Disk margin that practice asks for [-]."""

T = TypeVar("T")


def loops(shown: Shown) -> Section | None:
    """Plots and margins of laws that measure the machine, and what laws have learnt; None where there is neither."""
    tables = [table for table in (_margins(shown), _lines(shown), _learnt(shown)) if table.rows]
    return Section("loops", "Control loop", list(_figures(shown)), tables, list(_found(shown))) if tables else None


def _found(shown: Shown) -> Iterator[str]:
    """For which machine laws were found, and with which margins."""
    known = {label: law for label, result in shown.results.items() if (law := result.summary.law)}
    for label, law in known.items():
        yield f"The law{f' of {label}' if len(known) > 1 else ''}: {law.words}."


def _figures(shown: Shown) -> Iterator[Picture]:
    known = {label: found for label, one in shown.evaluations.items() if (found := one.loop_gains) is not None}
    for label, (hertz, gains) in known.items():
        several = label if len(known) > 1 else ""
        figures = plots.loop_figures(hertz, gains, ASKED, shown.results[label].scenario.output.nichols, several)
        for name, (caption, draw) in figures.items():
            yield Picture(f"loop-{name}-{label}" if several else f"loop-{name}", draw(), caption)


def _by_run(known: Mapping[str, T], rows: list[list[str]]) -> Iterator[T]:
    """What is known of each run; of several each begins with its name among the ``rows``."""
    for label, found in known.items():
        if len(known) > 1:
            rows.append([label])
        yield found


def _margins(shown: Shown) -> Table:
    """What each law's loop has in hand before it becomes unstable, as the summary says it."""
    known = {label: found for label, result in shown.results.items() if (found := result.summary.margins)}
    rows: list[list[str]] = []
    for table in _by_run(known, rows):
        if not table.stable:
            words = f": {table.unstable.words}" if table.unstable else ""
            rows.append([f"the closed loop is unstable{words}", *[DASH] * (len(LOOP_HEAD) - 1)])
        rows.append(["least, anywhere", *_loop(table)])
        rows += [[name, *_loop(one)] for name, one in table.motions.items()]
    note = (
        "Each motion opened by itself, the rest closed; the least also over single valves, single readings and all "
        "valves at once. Peak: of the sensitivity. Practice asks for 6 dB, 45°, a disk margin of 0.5 and a peak below "
        f"2. {DASH}: unlimited, or no crossing."
    )
    return Table("Margins of the control loop", LOOP_HEAD, rows, note)


def _lines(shown: Shown) -> Table:
    """Lines that laws follow, where they ended, a row per line."""
    known = {label: found for label, result in shown.results.items() if (found := result.summary.followed)}
    rows: list[list[str]] = []
    for lines in _by_run(known, rows):
        rows += [[f"{one.stated:g}", f"{one.low:.5g} to {one.high:.5g}", f"{one.found:.5g}"] for one in lines]
    note = "Margins count with each line where it is stated and at both ends of its range, whichever leaves least."
    return Table("Lines that the law follows", ("stated [Hz]", "within [Hz]", "at the end [Hz]"), rows, note)


def _learnt(shown: Shown) -> Table:
    """What laws have learnt of each mount at the end, a row per mount."""
    known = {label: found for label, result in shown.results.items() if (found := result.summary.learnt)}
    rows: list[list[str]] = []
    for mounts in _by_run(known, rows):
        for mount, told in mounts.items():
            cells = (told.get(name) for name in UNITS)
            rows.append([mount, *(DASH if one is None else f"{one.stated:.4g} → {one.learnt:.4g}" for one in cells)])
    head = ("mount", *(f"{name.replace('_', ' ')} [{unit}]" for name, unit in UNITS.items()))
    note = f"Stated → learnt, at the end of the run; play: threshold and half of the hysteresis. {DASH}: not learnt."
    return Table("What the law has learnt", head, rows, note)


def _loop(one: LoopMargins | PlaceMargins) -> list[str]:
    """Cells of a loop's row."""
    names = ("gain_db", "phase_deg", "disk", "peak_sensitivity", "peak_hz")
    crossings = ", ".join(map(number, getattr(one, "crossings_hz", ())))
    return [*(number(getattr(one, name, None)) for name in names), crossings or DASH]

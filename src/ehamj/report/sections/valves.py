"""What a law makes good of its valves: what they do, and what it believes of them."""

from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from ehamj.control.spools import followed
from ehamj.control.valves import KnownValve
from ehamj.judge.actuation import PASSIVE
from ehamj.pages import Section, Table
from ehamj.pages.words import DASH, number
from ehamj.report.shown import Shown
from ehamj.result import Result

EDGES: Final = ("supply–1", "1–tank", "supply–2", "2–tank")


def valves(shown: Shown) -> Section | None:
    """What each law believes beside what is so, and what it asks of the spools; None where nothing is made good."""
    known = {label: result for label, result in shown.results.items() if _known(result)}
    if not known:
        return None
    tables = [_beliefs(label if len(shown.results) > 1 else "", result) for label, result in known.items()]
    return Section("valves", "Valves made good", tables=[*tables, _spools(shown)])


def _known(result: Result) -> Sequence[KnownValve]:
    """What the law of a run knows of its valves."""
    return () if result.controller is None else result.controller.converter.valves


def _beliefs(label: str, result: Result) -> Table:
    """Rows of what is stated and believed, valves alike in one column."""
    plant = result.scenario.plant
    spools = () if result.controller is None else result.controller.converter.spools
    actuators, mounts = followed(plant, spools).actuators, plant.mounts
    fed = [bool(one.crossing and one.edges) for one in spools] or [False] * len(mounts)
    columns: dict[tuple[str, ...], list[str]] = {}
    for mount, actuator, valve, follows in zip(mounts, actuators, _known(result), fed, strict=True):
        if not actuator.passive:
            columns.setdefault(tuple(_cells(actuator, valve, follows)), []).append(mount)
    names = ["all" if len(columns) == 1 else ", ".join(found) for found in columns.values()]
    rows = [[name, *cells] for name, *cells in zip(_names(), *columns, strict=True)]
    title = "What the law believes of its valves" + (f", {label}" if label else "")
    note = (
        "Of the valve, and in brackets what the law believes where it differs. It was told by the machine that the law "
        "is held for, and by the shares in [control.linearisation]."
    )
    return Table(title, ["", *names], rows, note, kind="words")


def _names() -> Iterator[str]:
    yield from (f"overlap {edge} [mA]" for edge in EDGES)
    yield from ("half of hysteresis, with threshold [mA]", "null offset [mA]", "flow curve", "pressure drop", "supply")


def _cells(actuator: Any, valve: KnownValve, follows: bool) -> Iterator[str]:
    """Of one valve, in the order of `_names`; ``follows``: spool feedback takes back its play."""
    own = valve.numbers
    for true, believed in zip(actuator.overlap, (own.supply_1, own.tank_1, own.supply_2, own.tank_2), strict=True):
        yield _told(true, believed)
    yield "taken back by spool feedback" if follows else _told(actuator.threshold + 0.5 * actuator.hysteresis, own.play)
    yield _told(actuator.null_offset, own.offset)
    yield ("inverted" if own.curved else "not inverted") if actuator.flow_curve else "straight"
    yield "made good by measured pressures" if own.least < own.most else "not made good"
    yield DASH if own.least >= own.most else "measured" if own.supply_measured else f"stated, {own.supply / 1e5:g} bar"


def _told(true: float, believed: float) -> str:
    """A number, and what is believed where that is another."""
    return number(true) if np.isclose(true, believed, rtol=1e-9, atol=1e-12) else f"{number(true)} ({number(believed)})"


def _spools(shown: Shown) -> Table:
    """How far the spools stand from where an ideal valve's would for the same flow, by mount."""
    mounts = [
        m for m, a in zip(shown.scenario.plant.mounts, shown.scenario.plant.actuators, strict=True) if not a.passive
    ]
    rows = []
    for label, result in shown.results.items():
        if result.scenario.control.kind == PASSIVE or not result.dataset.time.size:
            continue
        rows += [] if shown.alone else [[label]]
        for name, values in _openings(result).items():
            found = dict(zip(result.scenario.plant.mounts, values.tolist(), strict=True))
            rows.append([name, *(number(found[mount]) if mount in found else DASH for mount in mounts)])
    note = (
        "By the recorded rows, RMS. Ideal: the opening at which a valve without lap, play or curve gives the same flow "
        "at its rated pressure drop. Apart: spool less ideal, which the law must add, and commands with "
        "K_v mA for each volt. Which limit comes nearest is in Limits, oil and power."
    )
    return Table("Openings of the valves [mA]", ["", *mounts], rows, note)


def _openings(result: Result) -> dict[str, Any]:
    """RMS of spool, ideal opening and what is between them, each (mount,) [mA]."""
    data, actuators = result.dataset, result.scenario.plant.actuators
    gain, leak = (np.array([getattr(one, name) for one in actuators]) for name in ("flow_gain", "flow_pressure"))
    flow, pressure = data.chamber_flow.values, data.chamber_pressure.values
    # The mean of what both chambers get; leakage of both kinds is K_C·P_L of it.
    metered = 0.5 * (flow[..., 0] - flow[..., 1]) + leak * (pressure[..., 0] - pressure[..., 1])
    spool, ideal = data.spool.values, metered / gain
    return {
        name: np.sqrt(np.nanmean(values**2, axis=0))
        for name, values in (("spool", spool), ("ideal", ideal), ("apart", spool - ideal))
    }

"""A run in ten lines: what a person asks for first."""

import re
from collections.abc import Mapping, Sequence
from typing import Any, Final

from ehamj.judge.attenuation import SHOWN_BANDS, quiet_bands
from ehamj.judge.learnt import Belief, nothing
from ehamj.judge.levels import SLAB, ByBand
from ehamj.judge.summary import PlaceMargins, Summary
from ehamj.judge.worse import LEAST, cancelled, made_worse
from ehamj.plant.axes import AXES

MICRO: Final = 1e6
NAMES: Final = {"z": "vertical", "rx": "roll", "ry": "pitch", "rz": "yaw"}
"""Motions in words, where these differ."""
SHORT_PLACES: Final = {"centre of gravity": "CG"}
"""Places by the names of the ten lines."""
MEAN: Final = (
    "floor: mean of the mounts, of a foot the ground below it; no place moves more than the loudest mount "
    f"by over {LEAST:g} dB"
)


PROCESSING: Final = re.compile(
    r"record .*(: (\S+ )?[xyz] from |, in this order: )|the ground starts from rest|floor \S+(, \S+ times as strong)?: "
    r"|mounts move with Luco-Wong|table .*: .* rows from line |record .*: times are rounded to "
)
"""Warnings that only say how a record was processed."""


def brief(summary: Summary) -> dict[str, str]:
    """Ten lines by what each is about."""
    state = "complete" if summary.complete else f"INCOMPLETE: {summary.failure}"
    found = {"run": f"{summary.name}: {simulated(summary)}, {state}"}
    if not summary.complete:  # the levels of what there is are those of a machine that runs away
        return found | {"until then": f"{_motion(summary.peak)}; {_valves(summary)}"} | _rest(summary)
    by = f", by {summary.criterion.title}" if summary.criterion.title else ""
    by += f", {mixed}" if (mixed := summary.mixed) else ""
    found |= {name: f"{said}{by}" for name, said in summary.criterion.briefly().items()}
    if worse := made_worse(summary.worse):
        found["worse"] = worse
    mixed = f", {mixed}" if mixed else ""
    first = summary.attenuation_first()
    if len(first) > 1:
        least_of = []
        for motions in (AXES, SLAB[len(AXES) :]):
            least = _least([table for motion in motions for table in first[motion].values()])
            least_of.append(f"least of {', '.join(motions)} {quiet_bands(least) or 'undecided in every band'}")
        found["attenuation"] = f"{'; '.join(least_of)}{mixed}"
    else:
        for place, said in told_attenuation(summary)["vertical"].items():
            found[SHORT_PLACES.get(place, place)] = f"vertically {said or 'undecided in every band'}{mixed}"
    found["peak motion"] = _motion(summary.peak)
    found["valves"] = _valves(summary)
    if summary.made_good:
        found["made good"] = f"{', '.join(summary.made_good)} of the valves, as the law knows them"
    found["margins"] = margins_in_words(summary)
    if summary.spools is not None:
        found["spool feedback"] = _spools(summary.spools)
    if summary.followed:
        found["lines"] = ", ".join(line.words for line in summary.followed)
    found |= {mount: f"learnt: {learnt_in_words(told)}" for mount, told in summary.learnt.items()}
    return found | _rest(summary)


def learnt_in_words(told: dict[str, Belief]) -> str:
    """What a mount has learnt."""
    if nothing(told):
        return "nothing"
    return ", ".join(one.words(name) for name, one in told.items())


def _spools(own: PlaceMargins) -> str:
    """What the loops about the spools have in hand."""
    up_to = f"crosses at {own.crossings_hz[-1]:.0f} Hz, " if own.crossings_hz else ""
    return f"{up_to}gain {_decibel(own.gain_db)}, phase {_degrees(own.phase_deg)}, disk {own.disk:.2f}"


def _rest(summary: Summary) -> dict[str, str]:
    """What else is to be known, and where."""
    return {
        "warnings": f"{len(summary.warnings)}: {summary.warnings[0]}" if summary.warnings else "none",
        "more": "result.summary, result.dataset (xarray), result.save(folder) with report and replay",
    }


def simulated(summary: Summary) -> str:
    """How much was simulated, how long it took, and on which engine, where that is not the default one."""
    timing = summary.timing
    engine = "" if timing.engine == "mujoco" else f" on the {timing.engine} engine"
    return f"{timing.simulated_s:g} s simulated in {timing.wall_s:.2g} s{engine}"


def told_attenuation(summary: Summary) -> dict[str, dict[str, str]]:
    """The attenuation that is told first in a few bands in words, by motion and place; empty where every band is
    undecided. What it is held against is told where it is negative though no place moves so much more than the floor's
    loudest mount."""
    found: dict[str, dict[str, str]] = {}
    for motion, places in summary.attenuation_first().items():
        small = motion in AXES and set(SHOWN_BANDS).intersection(cancelled(summary, motion))
        against = f" ({MEAN})" if small else ""
        told = {place: f"{said}{against}" if (said := quiet_bands(levels)) else "" for place, levels in places.items()}
        found[NAMES.get(motion, motion)] = told
    return found


def _least(tables: Sequence[ByBand]) -> ByBand:
    """The least of several tables in each band, of those in which it is known."""
    names = dict.fromkeys(band for table in tables for band in table)
    known = {band: [v for table in tables if (v := table.get(band)) is not None] for band in names}
    return {band: min(values, default=None) for band, values in known.items()}


def _largest(levels: Any, *last: str) -> float | None:
    """The largest number in nested tables, of those that end in the keys ``last``."""
    if levels is None or isinstance(levels, int | float):
        return levels
    if last and last[0] in levels:
        return _largest(levels[last[0]], *last[1:])
    found = [level for one in levels.values() if (level := _largest(one, *last)) is not None]
    return max(found, default=None)


def _motion(peak: Mapping[str, Any]) -> str:
    places = {"floor": "ground_velocity", "CG": "cg_velocity"}
    found = {name: _largest(peak.get(channel), "z") for name, channel in places.items()}
    said = [f"{name} {MICRO * level:.3g} µm/s" for name, level in found.items() if level is not None]
    turns = [_largest(peak.get("machine_displacement"), dof) for dof in ("rx", "ry", "rz")]
    said += [f"rotation {MICRO * max(turn):.3g} µrad"] if (turn := [one for one in turns if one is not None]) else []
    return ", ".join(said) or "no row was recorded"


def _valves(summary: Summary) -> str:
    command = _largest(summary.peak.get("valve_command"))
    said = "" if command is None else f"commands up to {command:.2g} V, "
    shares = {what: max(share for share in by.values()) for what, by in summary.saturation.items() if by}
    at = [f"{what} {100 * share:.2g} % of the time" for what, share in shares.items() if share > 0.0]
    return f"{said}at a limit: {', '.join(at)}" if at else f"{said}never at a limit"


def margins_in_words(summary: Summary) -> str:
    """What the control loop has in hand."""
    margins = summary.margins
    if margins is None:
        return "not known" if summary.python_law else "no feedback loop"
    before = "before the fault, " if summary.fault else ""
    after = [one for one in summary.fault or () if one.expected is not None and not one.expected.stable]
    if not margins.stable:
        return "the loop is UNSTABLE"
    if after:
        return f"after the fault {after[0].in_words()}, the loop is UNSTABLE"
    gain, phase = _decibel(margins.gain_db), _degrees(margins.phase_deg)
    return f"{before}gain {gain}, phase {phase}, disk {margins.disk:.2f}"


def _decibel(gain: float | None) -> str:
    return "unlimited" if gain is None else f"{gain:.1f} dB"


def _degrees(phase: float | None) -> str:
    return "unlimited" if phase is None else f"{phase:.0f}°"

"""Limits that a run reached, by the tally of every step and by the recorded rows; and the oil that it drew."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.columns import column
from ehamj.judge.summary import AtLimit, ByMount, Oil, Summary
from ehamj.mujoco.rows import Tally
from ehamj.plant.plant import Plant

WORDS = {
    "command": "the command was at its limit",
    "spool": "the spool was fully open",
    "spool_drive": "the spool's drive was at its limit",
    "cavitation": "oil cavitated",
}

LIMITS = {"command": "voltage", "spool": "flow", "spool_drive": "speed of the spool", "cavitation": "cavitation"}
"""What each limit is of."""
NEAREST = {"valve_command": "voltage", "spool": "flow"}
"""What the range of a channel limits."""


def saturation(tally: Tally, states: int, mounts: tuple[str, ...]) -> dict[str, ByMount]:
    """Share of the ``states`` that were counted at each limit, per mount."""
    return {name: dict(zip(mounts, (tally.limits[name] / states).tolist(), strict=True)) for name in WORDS}


def oil(tally: Tally, states: int, duration: float) -> Oil:
    """What was drawn in ``duration`` [s]."""
    flow, peak_flow, power = tally.drawn[0].tolist()
    mean = flow / states
    return Oil(mean_flow_m3_s=mean, peak_flow_m3_s=peak_flow, volume_m3=mean * duration, mean_power_w=power / states)


def warnings(shares: Mapping[str, ByMount]) -> list[str]:
    """Limits that were reached, in words."""
    worst = {name: max(of_mount.items(), key=lambda item: item[1]) for name, of_mount in shares.items()}
    return [
        f"{WORDS[name]} for up to {100 * share:.3g} % of the time ({mount})"
        for name, (mount, share) in worst.items()
        if share > 0
    ]


def binding(summary: Summary, plant: Plant) -> str:
    """Which limit binds, in words: those that were reached, the longest first; where none was, what is nearest to one.

    Empty where nothing commands the valves.
    """
    worst = {name: max(of.items(), key=lambda item: item[1]) for name, of in summary.saturation.items() if of}
    reached = sorted(((share, name, mount) for name, (mount, share) in worst.items() if share > 0.0), reverse=True)
    if reached:
        each = [f"{LIMITS[name]} ({WORDS[name]} for {_percent(share)} of the time, {m})" for share, name, m in reached]
        return f"{', then '.join(each)}"
    used = []
    for limit, channel, unit in (("voltage_limit", "valve_command", "V"), ("spool_stroke", "spool", "mA")):
        for mount, actuator in zip(plant.mounts, plant.actuators, strict=True):
            most, of = summary.peak.get(channel, {}).get(mount) or 0.0, getattr(actuator, limit)
            used.append((most / of, f"{most:.3g} of {of:g} {unit}", NEAREST[channel], mount))
    share, told, name, mount = max(used, default=(0.0, "", "", ""))
    return f"none was reached; nearest is {name}: {told} ({mount})" if share > 0.0 else ""


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def at_limit(dataset: xr.Dataset, plant: Plant, rate: float) -> dict[str, AtLimit | None]:
    """When each limit was reached, by the recorded rows at ``rate`` [Hz]; None where it was in none of them."""
    stretches: dict[str, list[tuple[int, int]]] = {name: [] for name in WORDS}
    for mount in range(len(plant.mounts)):
        for name, states in reached(dataset, plant, mount).items():
            stretches[name].append(_stretches(states))
    return {name: _longest(found, rate, plant.mounts) for name, found in stretches.items()}


def reached(dataset: xr.Dataset, plant: Plant, mount: int) -> dict[str, NDArray[np.bool_]]:
    """Which rows of a mount, by its number, are at each limit, (time,)."""
    command, spool = (column(dataset[name].variable, mount) for name in ("valve_command", "spool"))
    void = dataset["chamber_void"].variable[:, mount]
    limit, stroke, gain, frequency, drive = (
        getattr(plant.actuators[mount], name)
        for name in ("voltage_limit", "spool_stroke", "valve_gain", "valve_frequency", "spool_drive_limit")
    )
    target = gain * np.clip(command, -limit, limit)
    return {
        "command": np.abs(command) >= limit,
        "spool": np.abs(spool) >= stroke,
        "spool_drive": np.abs(frequency**2 * (target - spool)) >= drive,
        "cavitation": (column(void, 0) > 0.0) | (column(void, 1) > 0.0),
    }


def _stretches(states: NDArray[np.bool_]) -> tuple[int, int]:
    """The first row of states (time,) that is true, and how many there are at most without one between that is not; of
    none both are zero."""
    # One row before and one after, false, so that each stretch has a beginning and an end.
    edges = np.diff(np.pad(states.astype(np.int8), 1))
    begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return (int(begins[0]), int((ends - begins).max())) if begins.size else (0, 0)


def _longest(found: Sequence[tuple[int, int]], rate: float, mounts: tuple[str, ...]) -> AtLimit | None:
    """First time and longest stretch of all mounts, None if none was at the limit."""
    longest = [rows for _, rows in found]
    if not any(longest):
        return None
    first = min(begin for begin, rows in found if rows)
    return AtLimit(first_s=first / rate, longest_s=max(longest) / rate, mount=mounts[int(np.argmax(longest))])

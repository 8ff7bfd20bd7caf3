"""Attenuation against the level of the floor: what 10 V and two litres a minute are enough for.

A floor that is flat from 1 to 80 Hz passes below the machine as a wave; the nonlinear machine runs under the scenario's
control at each level. Above some level the valves clip. A law that isolates only from a few hertz on (`isolate_from`)
spends its voltage where it counts, and holds on longer.
"""

from collections.abc import Sequence
from typing import Annotated, Any, Final

import numpy as np
import xarray as xr
from pydantic import Field

from ehamj.control.kinds import CombinedSettings
from ehamj.control.settings import ControlSettings, DigitalSettings
from ehamj.criteria.vc import CLASSES
from ehamj.findings import finite
from ehamj.labels import table
from ehamj.pages.words import decibel
from ehamj.plots import Figure, Line, lines_chart, style
from ehamj.result import Result
from ehamj.run.many import simulate_many
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress, counted
from ehamj.studies.study import among, study
from ehamj.studies.variants import BANDS, RECORD_RATE

CLIPS: Final = 1e-3
"""Share of time from which a command at its limit counts as clipping [-]."""
SETTLED: Final = 2.0
"""Time from which pressures are judged [s]."""


class LevelSettings(Settings):
    """Which floors, and for how long.

    The law is the scenario's; a scenario without a digital controller is looked at under `CombinedSettings`. Laws that
    can be told to isolate from a frequency on are run both ways.
    """

    levels: tuple[Annotated[str, among(CLASSES)], ...] = Field(
        ("VC-E", "VC-C", "VC-B", "VC-A", "operating theatre", "workshop"), min_length=1, description="floors, by class"
    )
    duration: float = Field(10.0, ge=6, description="length of each run, at least 6 for the band at 2 Hz [s]")
    isolate_from: float = Field(5.0, gt=0, description="frequency from which the second law isolates [Hz]")


@study(
    "levels",
    LevelSettings,
    "attenuation against the floor's level, from VC-E to workshop: what the valves are enough for",
    small={"levels": ("VC-C",), "duration": 6.0},
)
def levels(scenario: Scenario, settings: LevelSettings, progress: Progress) -> Outcome:
    """A machine that cannot be simulated so is refused."""
    laws = _laws(scenario, settings.isolate_from)
    cases = [_case(scenario, settings, law, level) for law in laws.values() for level in settings.levels]
    found = level_table(list(laws), settings.levels, simulate_many(counted(cases, progress)))
    return Outcome(
        title="Attenuation against the floor's level",
        question="How strong a floor can this machine be isolated from, and what happens beyond?",
        answers=tuple(_answers(found, scenario.plant.layout.stress_names)),
        tables={"levels": found},
        drawings={
            "attenuation": Drawing(
                "Vertical attenuation of the centre of gravity over the floor's level, per third-octave band: under "
                f"the scenario's law (everywhere), and isolating from {settings.isolate_from:g} Hz on. Crosses: a "
                f"command is at its limit for {100 * CLIPS:g} % of the time or more. Below, how often that is.",
                lambda: _chart(found),
            )
        },
        notes=(
            f"Floor: flat from 1 to 80 Hz, a wave along +x at 200 m/s, {settings.duration:g} s, plates tied; levels "
            "are third-octave RMS velocities. Sensors are the scenario's.",
        ),
        numbers={law: {level: _numbers(found.sel(law=law, level=level)) for level in settings.levels} for law in laws},
    )


def _laws(scenario: Scenario, isolate_from: float) -> dict[str, ControlSettings]:
    """Controls by name."""
    control = CombinedSettings() if scenario.controller() is None else scenario.control
    later = control.isolating_from(isolate_from) if isinstance(control, DigitalSettings) else control
    found = {"everywhere": control}
    return found if later == control else found | {f"from {isolate_from:g} Hz": later}


def _case(scenario: Scenario, settings: LevelSettings, control: ControlSettings, level: str) -> Scenario:
    values = {
        "ground": {"kind": "broadband", "level": level, "wave": {"speed": 200.0}},
        "control": control.model_dump(exclude_none=True),
        "duration": settings.duration,
        "record_rate": RECORD_RATE,
        "plates": "tied" if all(a.rigid_foot for a in scenario.plant.actuators) else "sliding",
        "compare": (),
        "fault": (),
        "timestep": "auto",
    }
    return changed(scenario, values)


def level_table(laws: Sequence[str], chosen: Sequence[str], runs: Sequence[Result]) -> xr.Dataset:
    """Attenuation per band, clipped share, command and warp pressure of runs, (law, level)."""
    shape, over = (len(laws), len(chosen)), ("law", "level")
    attenuation = np.full((*shape, len(BANDS)), np.nan)
    clipped, command, warp = np.zeros((3, *shape))
    for at, run in zip(np.ndindex(*shape), runs, strict=True):
        found = run.summary.attenuation_db["z"]
        attenuation[at] = [np.nan if found[band] is None else found[band] for band in BANDS]
        clipped[at] = max(run.summary.saturation["command"].values())
        settled = run.dataset.sel(time=slice(SETTLED, None))
        command[at] = float(np.sqrt((settled["valve_command"].values ** 2).mean()))
        warp[at] = warp_share(run, settled)
    flat = [CLASSES[level] for level in chosen]
    return table(
        "attenuation against the floor's level",
        {
            "law": (list(laws), "", "law isolates"),
            "level": (list(chosen), "", "floor"),
            "band": ([float(band) for band in BANDS], "Hz", "third-octave band"),
        },
        attenuation=(attenuation, "dB", "vertical attenuation"),
        clipped=(over, clipped, "1", "share of time with a command at its limit"),
        command=(over, command, "V", "RMS of the commands"),
        warp=(over, warp, "1", "largest warp pressure over supply pressure"),
        velocity=(("level",), flat, "m/s", "level, RMS velocity per third-octave band"),
    )


def warp_share(run: Result, part: xr.Dataset) -> float:
    """Largest load pressure in patterns that move nothing (warp), over the supply pressure [-]; 0 without any."""
    pressure = (part["chamber_pressure"].sel(chamber=1) - part["chamber_pressure"].sel(chamber=2)).values
    layout = run.scenario.plant.layout
    still = pressure @ layout.stresses @ layout.stresses.T / max(sum(layout.active), 1)  # orthogonal, of length √n each
    return float(np.abs(still).max() / run.scenario.supply.pressure)


def _numbers(one: xr.Dataset) -> dict[str, Any]:
    bands = zip(BANDS, one["attenuation"].values.tolist(), strict=True)
    return {
        "attenuation_db": {band: finite(level) for band, level in bands},
        "clipped_share": float(one["clipped"]),
        "command_rms_v": float(one["command"]),
        "warp_share": float(one["warp"]),
    }


def _answers(levels_over: xr.Dataset, patterns: Sequence[str]) -> list[str]:
    found = []
    for name in levels_over.law.values:
        one = levels_over.sel(law=name)
        free = one.clipped.values < CLIPS
        quiet = [str(level) for level, holds in zip(one.level.values, free, strict=True) if holds]
        until = f"up to {quiet[-1]} the valves do not clip" if quiet else "the valves clip at every level"
        at_ten = one.attenuation.sel(band=10.0).values
        if quiet and not free.all():
            until += f", from {one.level.values[int(np.argmin(free))]} on they do"
        if (gone := at_ten < 0.5 * np.nanmax(at_ten)).any():
            until += f"; isolation collapses at {one.level.values[int(np.argmax(gone))]}"
        words = "; ".join(
            f"{level} {decibel(float(quieter))} dB ({100 * clipped:.2g} %)"
            for level, quieter, clipped in zip(one.level.values, at_ten, one.clipped.values, strict=True)
        )
        found.append(f"Isolating {name}: {until}. At 10 Hz (share of time clipped): {words}.")
    worst = float(levels_over.warp.max())
    holds = f"The pressure balance holds: warp pressure stays below {100 * worst:.2g} % of the supply pressure"
    if patterns:
        many = "" if len(patterns) == 1 else f" in all {len(patterns)} patterns that move nothing"
        found.append(f"{holds}{many}.")
    return found


def _chart(levels_over: xr.Dataset) -> Figure:
    """A panel per law: attenuation per band, crosses where valves clip; below, how often they do."""
    micro = 1e6 * levels_over.velocity.values
    panels: dict[str, list[Line]] = {}
    shares: list[Line] = []
    for row, name in enumerate(levels_over.law.values):
        one = levels_over.sel(law=name)
        clips = one.clipped.values >= CLIPS
        lines = [
            Line("" if row else f"{band:g} Hz", micro, one.attenuation.sel(band=band).values, column)
            for column, band in enumerate(levels_over.band.values)
        ]
        at = np.tile(micro[clips], levels_over.sizes["band"])
        dips = one.attenuation.transpose("band", "level").values[:, clips].ravel()
        lines += [Line("", micro[~clips], level[~clips], k, marker=".") for k, level in
                  enumerate(one.attenuation.transpose("band", "level").values)]  # fmt: skip
        lines.append(Line("" if row else "valves clip", at, dips, style.INK, marker="x"))
        panels[f"{name} [dB]"] = lines
        shares.append(Line(f"isolating {name}", micro, 100 * one.clipped.values, style.INK, row))
    panels["clipped [%]"] = shares
    across = "floor, RMS velocity per third-octave band [µm/s]"
    marks = {str(level): float(at) for level, at in zip(levels_over.level.values, micro, strict=True)}
    return lines_chart("Attenuation against the floor's level", across, panels, "x", marks=marks)

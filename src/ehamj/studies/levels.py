"""Attenuation against the level of the floor: what 10 V and two litres a minute are enough for.

A floor that is flat from 1 to 80 Hz passes below the machine as a wave; the nonlinear machine runs under the scenario's
control at each level. Above some level the valves clip. A law that isolates only from a few hertz on (`isolate_from`)
spends its voltage where it counts, and holds on longer.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.control.architectures.combined import CombinedSettings
from ehamj.control.architectures.feedforward import FeedforwardSettings
from ehamj.control.architectures.modal import ModalSettings
from ehamj.control.commands import Passive
from ehamj.criteria.vc import CLASSES
from ehamj.errors import InputError
from ehamj.plant.mounts import WARP
from ehamj.plots.charts import Line, lines_chart
from ehamj.result import Result
from ehamj.run.simulate import simulate_many
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Drawing, Outcome, Progress, labelled, silent
from ehamj.studies.variants import changed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

BANDS: Final = ("2", "5", "10", "20", "50", "100")
RECORD_RATE: Final = 4000.0
"""Rows per second [Hz]: motion above half of them would be read as if it were slow."""
SETTLED: Final = 2.0
"""Time from which pressures are judged [s]."""


@dataclass(frozen=True)
class LevelStudy:
    """Which floors, and for how long.

    The law is the scenario's; a scenario without a digital controller is looked at under `CombinedSettings`. Laws that
    can be told to isolate from a frequency on are run both ways.

    Raises:
        InputError: if a level is unknown, or the runs are too short for a band.
    """

    scenario: Scenario
    levels: tuple[str, ...] = ("VC-E", "VC-C", "VC-B", "VC-A", "operating theatre", "workshop")
    duration: float = 10.0
    isolate_from: float = 5.0
    """Frequency from which the second law isolates [Hz]."""

    def __post_init__(self) -> None:
        for level in self.levels:
            if level not in CLASSES:
                raise InputError(f"levels: {level!r} must be one of {', '.join(CLASSES)}")
        if not self.duration >= 6.0:
            raise InputError(f"duration = {self.duration:g} s: must be at least 6 s, for the band at 2 Hz")


def levels(study: LevelStudy, progress: Progress = silent) -> Outcome:
    """Run the study.

    Raises:
        InputError: if the machine cannot be simulated so.
    """
    laws = _laws(study)
    names = list(laws)
    cases = [_case(study, laws[name], level) for name in names for level in study.levels]
    progress(f"{len(cases)} nonlinear runs")
    runs = simulate_many(cases)
    table = level_table(names, study.levels, runs)
    return Outcome(
        title="Attenuation against the floor's level",
        question="How strong a floor can this machine be isolated from, and what happens beyond?",
        answers=tuple(_answers(table)),
        tables={"levels": table},
        drawings={
            "attenuation": Drawing(
                "Vertical attenuation of the centre of gravity over the floor's level, per third-octave band; thick: "
                "the scenario's law, thin: isolating from "
                f"{study.isolate_from:g} Hz on. Below, the share of time at which a command is at its limit.",
                lambda: _chart(table),
            )
        },
        notes=(
            f"Floor: flat from 1 to 80 Hz, a wave along +x at 200 m/s, {study.duration:g} s, plates tied; levels are "
            "third-octave RMS velocities. Sensors are the scenario's.",
        ),
        numbers={
            name: {
                str(level): {
                    "attenuation_db": {band: _number(one.attenuation.sel(band=float(band))) for band in BANDS},
                    "clipped_share": float(one.clipped),
                    "command_rms_v": float(one.command),
                    "warp_share": float(one.warp),
                }
                for level in study.levels
                for one in (table.sel(law=name, level=level),)
            }
            for name in names
        },
    )


def _laws(study: LevelStudy) -> dict[str, Any]:
    """Controls by name."""
    control = study.scenario.control
    if isinstance(control, Passive) or study.scenario.controller() is None:
        control = CombinedSettings()
    found = {"everywhere": control}
    later = {"isolate_from": study.isolate_from}
    if isinstance(control, CombinedSettings):
        parts = tuple(
            part.model_copy(update=later) if isinstance(part, FeedforwardSettings | ModalSettings) else part
            for part in control.parts
        )
        found[f"from {study.isolate_from:g} Hz"] = control.model_copy(update={"parts": parts})
    elif isinstance(control, FeedforwardSettings | ModalSettings):
        found[f"from {study.isolate_from:g} Hz"] = control.model_copy(update=later)
    return found


def _case(study: LevelStudy, control: Any, level: str) -> Scenario:
    floor = {"kind": "broadband", "level": level, "wave": {"speed": 200.0}}
    return changed(
        study.scenario,
        ground=floor,
        control=control.model_dump(exclude_none=True),
        duration=study.duration,
        record_rate=RECORD_RATE,
        plates="tied" if all(a.rigid_foot for a in study.scenario.plant.actuators) else "sliding",
        compare=(),
        timestep="auto",
    )


def level_table(names: list[str], chosen: tuple[str, ...], runs: list[Result]) -> xr.Dataset:
    """Attenuation per band, clipped share, command and warp pressure of runs, (law, level)."""
    shape = (len(names), len(chosen))
    attenuation = np.full((*shape, len(BANDS)), np.nan)
    clipped, command, warp = np.zeros((3, *shape))
    for at, run in zip(np.ndindex(*shape), runs, strict=True):
        found = run.summary.attenuation_db["z"]
        attenuation[at] = [np.nan if found[band] is None else found[band] for band in BANDS]
        clipped[at] = max(run.summary.saturation["command"].values())
        settled = run.dataset.sel(time=slice(SETTLED, None))
        command[at] = float(np.sqrt((settled["valve_command"].values ** 2).mean()))
        warp[at] = warp_share(run, settled)
    over = ("law", "level")
    flat = [CLASSES[level] for level in chosen]
    return xr.Dataset(
        {
            "attenuation": labelled((*over, "band"), attenuation, "dB", "vertical attenuation"),
            "clipped": labelled(over, clipped, "1", "share of time with a command at its limit"),
            "command": labelled(over, command, "V", "RMS of the commands"),
            "warp": labelled(over, warp, "1", "largest warp pressure over supply pressure"),
            "velocity": labelled(("level",), flat, "m/s", "level, RMS velocity per third-octave band"),
        },
        {
            "law": labelled(("law",), names, "", "law isolates"),
            "level": labelled(("level",), list(chosen), "", "floor"),
            "band": labelled(("band",), [float(band) for band in BANDS], "Hz", "third-octave band"),
        },
        {"title": "attenuation against the floor's level"},
    )


def warp_share(run: Result, part: xr.Dataset) -> float:
    """Largest load pressure in the warp pattern, which moves nothing, over the supply pressure [-]."""
    pressure = part["chamber_pressure"].sel(chamber=1) - part["chamber_pressure"].sel(chamber=2)
    balance = np.abs(pressure.values @ np.array(WARP)) / len(WARP)
    return float(balance.max() / run.scenario.supply.pressure)


def _number(value: xr.DataArray) -> float | None:
    number = float(value)
    return number if np.isfinite(number) else None


def _answers(table: xr.Dataset) -> list[str]:
    found = []
    for name in table.law.values:
        one = table.sel(law=name)
        quiet = [str(level) for level in one.level.values if float(one.clipped.sel(level=level)) < 1e-3]
        until = f"up to {quiet[-1]} the valves do not clip" if quiet else "the valves clip at every level"
        words = "; ".join(
            f"{level} {float(one.attenuation.sel(level=level, band=10.0)):.0f} dB"
            f" ({100 * float(one.clipped.sel(level=level)):.2g} %)"
            for level in one.level.values
        )
        found.append(f"Isolating {name}: {until}. At 10 Hz (share of time clipped): {words}.")
    worst = float(table.warp.max())
    found.append(f"The pressure balance holds: warp pressure stays below {100 * worst:.2g} % of the supply pressure.")
    return found


def _chart(table: xr.Dataset) -> "Figure":
    micro = 1e6 * table.velocity.values
    lines, shares = [], []
    for row, name in enumerate(table.law.values):
        for column, band in enumerate(table.band.values):
            values = table.attenuation.sel(law=name, band=band).values
            label = f"{band:g} Hz" if row == 0 else (str(name) if column == 0 else "")
            lines.append(Line(label, micro, values, column, row, width=2.0 if row == 0 else 1.0))
        shares.append(Line("", micro, 100 * table.clipped.sel(law=name).values, 7, row, width=2.0 if row == 0 else 1.0))
    panels = {"attenuation [dB]": lines, "clipped [%]": shares}
    across = "floor, RMS velocity per third-octave band [µm/s]"
    marks = {str(level): float(at) for level, at in zip(table.level.values[:5], micro[:5], strict=False)}
    return lines_chart("Attenuation against the floor's level", across, panels, "x", marks=marks)

"""Preview: what metres buy between a sensor in the floor upstream and a machine that is isolated from a frequency on.

A floor that is flat from 1 to 80 Hz passes below the machine as a wave, along +x. The scenario's law is told where
isolation begins (`isolate_from`), without a sensor upstream and with one at each distance; and with a wave that is
slower than is believed, whose phase comes out wrong the more the farther the sensor stands.
"""

from typing import Annotated, Any, Final

import numpy as np
import xarray as xr
from pydantic import Field

from ehamj.control.commands import Passive
from ehamj.control.settings import DigitalSettings
from ehamj.criteria.vc import CLASSES
from ehamj.errors import InputError
from ehamj.findings import finite
from ehamj.labels import table
from ehamj.pages.words import decibel
from ehamj.plots import Figure, Line, lines_chart
from ehamj.run.many import simulate_many
from ehamj.scenario.load import changed
from ehamj.scenario.model import Engine, Scenario
from ehamj.settings import Positive, Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress
from ehamj.studies.study import among, study
from ehamj.studies.variants import BANDS, RECORD_RATE, derived_law
from ehamj.synthesis.kinds import CONTROLS

BELIEFS: Final = ("right", "wrong")
"""Whether the wave is as fast as is believed."""


class PreviewSettings(Settings):
    """Which floors, and where the sensor stands; 0 m, without one, is always beside."""

    levels: tuple[Annotated[str, among(CLASSES)], ...] = Field(
        ("VC-C", "VC-A"), min_length=1, description="floors, by class"
    )
    metres: tuple[Positive, ...] = Field(
        (5.0, 10.0, 20.0, 40.0), min_length=1, description="distances of the sensor from the mount plane's centre [m]"
    )
    speed: Positive = Field(200.0, description="apparent wave speed that is believed [m/s]")
    off: float = Field(0.05, ge=0, lt=1, description="share by which the wave is slower where belief is wrong [-]")
    isolate_from: Positive = Field(5.0, description="frequency from which the law isolates [Hz]")
    duration: float = Field(15.0, ge=3, description="length of each run, at least 6 for the band at 2 Hz [s]")
    engine: Engine = Field("small-motion", description="what steps the machines")


@study(
    "preview",
    PreviewSettings,
    "what metres buy between a sensor upstream and the machine, and what a wave costs that is not as fast as believed",
    small={"levels": ("VC-C",), "metres": (20.0,), "duration": 3.0},
)
def preview(scenario: Scenario, settings: PreviewSettings, progress: Progress) -> Outcome:
    """A scenario without a law that can be told where isolation begins is refused."""
    law = derived_law(scenario).isolating_from(settings.isolate_from)
    able = sorted(name for name, one in CONTROLS.items() if "isolate_from" in one.model_fields)
    if law == scenario.control and law.isolating_from(2.0 * settings.isolate_from) == law:
        raise InputError(
            f"control.kind = {law.kind!r}: cannot be told where isolation begins; "
            f"{', '.join(map(repr, able))} and what is combined of them can"
        )
    found = preview_table(scenario, law, settings, progress)
    off = f"{100.0 * settings.off:g} %"
    return Outcome(
        title="Preview",
        question="What do metres buy between a sensor in the floor upstream and the machine?",
        answers=tuple(_answers(found, settings)),
        tables={"preview": found},
        drawings={
            "preview": Drawing(
                "Vertical attenuation of the centre of gravity over the distance of the sensor upstream (0: without "
                f"one), the law isolating from {settings.isolate_from:g} Hz on. Dashed: the wave is {off} slower than "
                "the law believes. Below, the commands.",
                lambda: _chart(found),
            )
        },
        notes=(
            f"Floor: flat from 1 to 80 Hz, a wave along +x at {settings.speed:g} m/s (wrong belief: {off} less), "
            f"{settings.duration:g} s; levels are third-octave RMS velocities. Sensors are the scenario's, the one "
            "upstream as those below the mounts.",
            "Below the frequency from which the law isolates the machine is meant to follow the floor: 0 dB are wanted "
            "there.",
        ),
        numbers={
            level: {belief: _numbers(found.sel(level=level, belief=belief)) for belief in BELIEFS}
            for level in settings.levels
        },
    )


def _metres(settings: PreviewSettings) -> tuple[float, ...]:
    return 0.0, *settings.metres


def preview_table(
    scenario: Scenario, law: DigitalSettings, settings: PreviewSettings, progress: Progress
) -> xr.Dataset:
    """Attenuation (level, belief, metres, band); RMS and clipping of the commands (level, belief, metres)."""
    metres = _metres(settings)
    shape, over = (len(settings.levels), len(BELIEFS), len(metres)), ("level", "belief", "metres")
    speeds = settings.speed, settings.speed * (1.0 - settings.off)
    places = [at for at in np.ndindex(*shape) if at[2] or not at[1]]  # without a sensor nothing is believed
    wanted = [_case(scenario, law, settings, settings.levels[k], speeds[b], metres[m]) for k, b, m in places]
    progress(f"{len(wanted)} machines")
    attenuation, (command, clipped) = np.full((*shape, len(BANDS)), np.nan), np.zeros((2, *shape))
    for at, run in zip(places, simulate_many(wanted, engine=settings.engine), strict=True):
        own = run.summary.attenuation_db["z"]
        attenuation[at] = [np.nan if (level := own.get(band)) is None else level for band in BANDS]
        command[at] = float(np.sqrt((run.dataset["valve_command"].values ** 2).mean()))
        clipped[at] = max(run.summary.saturation["command"].values())
    for values in (attenuation, command, clipped):
        values[:, 1, 0] = values[:, 0, 0]
    return table(
        "attenuation with a sensor upstream",
        {
            "level": (list(settings.levels), "", "floor"),
            "belief": (list(BELIEFS), "", "belief of the wave's speed"),
            "metres": (list(metres), "m", "distance of the sensor upstream"),
            "band": ([float(band) for band in BANDS], "Hz", "third-octave band"),
        },
        attenuation=(attenuation, "dB", "vertical attenuation"),
        command=(over, command, "V", "RMS of the commands"),
        clipped=(over, clipped, "1", "share of time with a command at its limit"),
    )


def _case(
    scenario: Scenario, law: DigitalSettings, settings: PreviewSettings, level: str, speed: float, metres: float
) -> Scenario:
    """The scenario on a floor of a level that passes at a speed [m/s], with a sensor so far upstream [m]; 0: none."""
    believed = {"position": [-metres, 0.0, 0.0], "wave": {"speed": settings.speed}}
    values: dict[str, Any] = {
        "ground": {"kind": "broadband", "level": level, "wave": {"speed": speed}},
        "sensors.upstream": believed if metres else None,
        "duration": settings.duration,
        "record_rate": max(scenario.record_rate, RECORD_RATE),
        "compare": (),
        "variants": {},
        "fault": (),
    }
    if all(actuator.rigid_foot for actuator in scenario.plant.actuators):
        values["plates"] = "tied"
    made = changed(scenario.model_copy(update={"control": Passive.stated()}), values)
    held = made.installation if law.designed_for is None else law.designed_for
    sensors = held.sensors.model_copy(update={"upstream": made.sensors.upstream})
    held = held.model_copy(update={"sensors": sensors})
    return made.model_copy(update={"control": law.model_copy(update={"designed_for": held})})


def _numbers(found: xr.Dataset) -> dict[str, Any]:
    """By distance."""
    numbers = {}
    for metres in found["metres"].values.tolist():
        own = found.sel(metres=metres)
        levels = {band: finite(float(own["attenuation"].sel(band=float(band)))) for band in BANDS}
        command = {"command_rms_v": float(own["command"]), "clipped_share": float(own["clipped"])}
        numbers[f"{metres:g} m"] = {"attenuation_db": levels, **command}
    return numbers


def _answers(found: xr.Dataset, settings: PreviewSettings) -> list[str]:
    known = [band for band in BANDS if np.isfinite(found["attenuation"].sel(band=float(band))).all()]
    said, bands = [], [band for band in known if float(band) >= settings.isolate_from]
    if not bands:
        return [f"From {settings.isolate_from:g} Hz on no band is decided: the runs are too short for it."]
    for level in settings.levels:
        for metres in _metres(settings):
            own = found.sel(level=level, metres=metres)
            right, wrong = (own.sel(belief=belief) for belief in BELIEFS)
            how = f"a sensor {metres:g} m upstream" if metres else "no sensor upstream"
            parts = [f"{_levels(right, bands)} with {float(right['command']):.1f} V RMS"]
            if clipped := float(right["clipped"]):
                parts.append(f"at its limit for {100.0 * clipped:.2g} % of the time")
            if metres and settings.off:
                parts.append(f"{_levels(wrong, bands)} in a wave {100.0 * settings.off:g} % slower than believed")
            said.append(f"{level}, {how}: {'; '.join(parts)}.")
    return said


def _levels(own: xr.Dataset, bands: list[str]) -> str:
    levels = [decibel(float(own["attenuation"].sel(band=float(band)))) for band in bands]
    return f"{', '.join(levels)} at {', '.join(bands)} Hz"


def _chart(found: xr.Dataset) -> Figure:
    panels: dict[str, list[Line]] = {}
    metres = found["metres"].values
    for level in found["level"].values.tolist():
        panels[f"{level} [dB]"] = [
            Line(
                f"{band:g} Hz" if belief == "right" else "",
                metres,
                found["attenuation"].sel(level=level, belief=belief, band=band).values,
                color,
                BELIEFS.index(belief),
            )
            for color, band in enumerate(found["band"].values.tolist())
            for belief in BELIEFS
        ]
    panels["command [V]"] = [
        Line(level, metres, found["command"].sel(level=level, belief="right").values, color)
        for color, level in enumerate(found["level"].values.tolist())
    ]
    return lines_chart("What metres buy", "distance of the sensor upstream [m]", panels, "")

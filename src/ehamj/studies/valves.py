"""Valves: what each imperfection of real ones costs, without and with the stage that makes good what is known of them.

The machine is taken with ideal valves and a pump that holds its pressure; then it gets one imperfection at a time, and
all together. Each law is derived for the very machine it runs on, so that the stage knows its valves exactly.
"""

from typing import Any, Final

import numpy as np
import xarray as xr
from pydantic import Field

from ehamj.control.describing import across
from ehamj.findings import finite
from ehamj.isolator.presets import VALVES
from ehamj.labels import table
from ehamj.linear.loop import Loop, feeds_back, linear_under
from ehamj.linear.margins import margins_behind
from ehamj.plots import Figure, lines_chart
from ehamj.run.many import simulate_many
from ehamj.scenario.load import changed
from ehamj.scenario.model import Engine, Scenario
from ehamj.settings import NotNegative, Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress, curves
from ehamj.studies.study import study
from ehamj.studies.variants import RECORD_RATE, check_band, derived_law

BANDS: Final = ("5", "10", "20", "50", "100")
REAL: Final = VALVES["proportional"]
IDEAL: Final = "ideal"
ALL: Final = "all together"
OPENINGS: Final = np.geomspace(0.02, 4.0, 16)
"""Amplitudes of the wanted opening [mA]."""
LAWS: Final = ("without", "with")
"""The law without and with the stage."""


class ValveSettings(Settings):
    """Imperfections of every valve that obeys; 0, or false, leaves one out."""

    overlap: NotNegative = Field(REAL["overlap"][0], description="overlap of each edge [mA]")
    hysteresis: NotNegative = Field(REAL["hysteresis"], description="hysteresis [mA]")
    threshold: NotNegative = Field(REAL["threshold"], description="threshold [mA]")
    flow_curve: bool = Field(True, description="the flow curve of valve = 'proportional'")
    air_fraction: float = Field(0.005, ge=0, lt=1, description="entrained air at 1 atm, by volume [-]")
    shared_pump: bool = Field(True, description="one pump for all valves, whose pressure moves (supply.dynamic)")
    duration: float = Field(15.0, ge=2, description="length of each run [s]")
    band: float = Field(10.0, description="third-octave band that the answers name, of 5, 10, 20, 50, 100 [Hz]")
    engine: Engine = Field("small-motion", description="what steps the machines")

    def cases(self) -> dict[str, dict[str, Any]]:
        """What is otherwise than with ideal valves, by case: keys of an actuator, or dotted ones of the scenario."""
        own: dict[str, dict[str, Any]] = {
            "overlap": {"overlap": [self.overlap] * 4} if self.overlap else {},
            "hysteresis": {"hysteresis": self.hysteresis} if self.hysteresis else {},
            "threshold": {"threshold": self.threshold} if self.threshold else {},
            "flow curve": {"flow_curve": REAL["flow_curve"]} if self.flow_curve else {},
            "air": {"air_fraction": self.air_fraction} if self.air_fraction else {},
            "shared pump": {"supply.dynamic": True} if self.shared_pump else {},
        }
        single = {name: values for name, values in own.items() if values}
        whole = {key: value for values in single.values() for key, value in values.items()}
        return {IDEAL: {}, **single, **({ALL: whole} if len(single) > 1 else {})}


@study(
    "valves",
    ValveSettings,
    "what each imperfection of real valves costs, without and with linearisation",
    small={
        "duration": 2.0,
        "hysteresis": 0.0,
        "threshold": 0.0,
        "flow_curve": False,
        "air_fraction": 0.0,
        "shared_pump": False,
    },
)
def valves(scenario: Scenario, settings: ValveSettings, progress: Progress) -> Outcome:
    """A scenario without a digital law, and a band that is not looked at, are refused."""
    derived_law(scenario)
    check_band(settings.band, BANDS)
    found = attenuations(scenario, settings, progress)
    cost = found["attenuation"].sel(case=IDEAL) - found["attenuation"]
    crossed = across_overlap(scenario, settings)
    return Outcome(
        title="Valves",
        question="What does each imperfection of real valves cost, and what does linearisation bring back?",
        answers=(*_answers(found, settings), *(() if crossed is None else _told(crossed))),
        tables={"attenuation": found, "cost": _costs(cost), **({} if crossed is None else {"across": crossed})},
        drawings={
            "attenuation": Drawing(
                "Vertical attenuation of the centre of gravity, without and with the stage that makes good what is "
                "known of the valves.",
                lambda: _chart(found),
            )
        },
        notes=(
            "Each law is derived for the very machine that it runs on: the stage knows its valves, as exactly as "
            "[control.linearisation] lets it. What it costs to know less of them: overlap = 0.8 there.",
            f"Floor and instruments are the scenario's, {settings.duration:g} s; values of the valves are typical of "
            "catalogues, and assumed.",
        ),
        numbers={f"{law} linearisation": _numbers(found["attenuation"].sel(law=law)) for law in LAWS},
    )


def attenuations(scenario: Scenario, settings: ValveSettings, progress: Progress) -> xr.Dataset:
    """Vertical attenuation of the centre of gravity (law, case, band), and clipping (law, case)."""
    cases = settings.cases()
    wanted = [_machine(scenario, settings, values, law) for law in LAWS for values in cases.values()]
    progress(f"{len(wanted)} machines")
    levels: list[list[float]] = []
    clipped: list[float] = []
    for run in simulate_many(wanted, engine=settings.engine):
        own = run.summary.attenuation_db["z"]
        levels.append([np.nan if (level := own.get(band)) is None else level for band in BANDS])
        clipped.append(max(run.summary.saturation["command"].values()))
    shape = (len(LAWS), len(cases))
    return table(
        "attenuation with imperfect valves",
        {
            "law": (list(LAWS), "", "linearisation"),
            "case": (list(cases), "", "imperfection"),
            "band": ([float(band) for band in BANDS], "Hz", "third-octave band"),
        },
        attenuation=(np.reshape(levels, (*shape, len(BANDS))), "dB", "vertical attenuation"),
        clipped=(("law", "case"), np.reshape(clipped, shape), "1", "share of time with a command at its limit"),
    )


def _machine(scenario: Scenario, settings: ValveSettings, values: dict[str, Any], law: str) -> Scenario:
    """The scenario's machine with ideal valves but for some values, under a law that knows it."""
    control = derived_law(scenario)
    obeying = [name for name, one in scenario.actuators.items() if not one.passive]
    own = {"valve": "paper", **dict.fromkeys(("hysteresis", "threshold", "air_fraction"), 0.0)}
    own |= {"overlap": [0.0] * 4, "flow_curve": [], "null_offset": 0.0}
    own |= {key: value for key, value in values.items() if "." not in key}
    base: dict[str, Any] = {
        "duration": settings.duration,
        "record_rate": max(scenario.record_rate, RECORD_RATE),
        "compare": [],
        "variants": {},
        "supply.dynamic": bool(values.get("supply.dynamic", False)),
        "control.linearisation": law == "with" and (control.linearisation or True),
    }
    if all(actuator.rigid_foot for actuator in scenario.plant.actuators):
        base["plates"] = "tied"
    free = scenario.model_copy(update={"control": control.model_copy(update={"designed_for": None})})
    made = changed(free, base | {f"actuators.{name}.{key}": value for name in obeying for key, value in own.items()})
    held = made.control.model_copy(update={"designed_for": made.installation})
    return made.model_copy(update={"control": held})


def across_overlap(scenario: Scenario, settings: ValveSettings) -> xr.Dataset | None:
    """Gain and phase of a valve with all imperfections behind the stage, and the loop's least margins with them, by
    what the law believes of its overlap (overlap, amplitude); None where there is no overlap, or no feedback."""
    if not settings.overlap:
        return None
    machine = _machine(scenario, settings, [*settings.cases().values()][-1], "with")
    law = machine.controller()
    if law is None or not feeds_back(law):
        return None
    loop, model = Loop.of(machine, law), linear_under(machine.plant, law)
    k = machine.plant.mounts.index(machine.plant.obeying.mounts[0])
    found = across(law.converter.valves[k], machine.plant.actuators[k], OPENINGS)
    factors = np.array(list(found.values()))
    left = margins_behind(model, loop, factors.ravel()).reshape(*factors.shape, 3)
    left[~np.isfinite(left)] = np.nan  # where nothing passes there is nothing to lose
    return table(
        "margins across the overlap",
        {
            "overlap": (list(found), "", "overlap that the law believes"),
            "amplitude": (OPENINGS, "mA", "amplitude of the wanted opening"),
        },
        factor=(np.abs(factors), "1", "gain over the ideal valve's"),
        phase=(np.degrees(np.angle(factors)), "deg", "phase"),
        gain_margin=(left[..., 0], "dB", "gain margin"),
        phase_margin=(left[..., 1], "deg", "phase margin"),
    )


def _told(crossed: xr.Dataset) -> list[str]:
    """Of each belief, where the loop is nearest to its limits."""
    said = []
    for words in crossed["overlap"].values.tolist():
        own = crossed.sel(overlap=words)
        most = float(own["factor"].max())
        at = {
            name: float(own["amplitude"].values[np.nanargmin(own[name].values)])
            for name in ("gain_margin", "phase_margin")
        }
        gain, phase = (float(own[name].min()) for name in at)
        said.append(
            f"Across the overlap, believed {words}: the valve's gain is up to {most:.2f} of the ideal one's; by the "
            f"describing function {gain:.1f} dB of gain are left at {at['gain_margin']:.2g} mA wanted, and "
            f"{phase:.0f}° of phase at {at['phase_margin']:.2g} mA."
        )
    return said


def _numbers(levels: xr.DataArray) -> dict[str, Any]:
    """By case and band [dB]; None where nothing is decided."""
    cases = levels["case"].values.tolist()
    return {case: {b: finite(float(levels.sel(case=case, band=float(b)))) for b in BANDS} for case in cases}


def _costs(cost: xr.DataArray) -> xr.Dataset:
    """What each case has less than ideal valves, and what linearisation brings back."""
    over: dict[str, Any] = {
        "case": (cost["case"].values.tolist(), "", "imperfection"),
        "band": (cost["band"].values.tolist(), "Hz", "third-octave band"),
    }
    columns: dict[str, Any] = {}
    for law in LAWS:
        columns[law] = (cost.sel(law=law).transpose("case", "band").values, "dB", f"cost {law} linearisation")
    return table("what imperfections cost", over, **columns)


def _answers(found: xr.Dataset, settings: ValveSettings) -> list[str]:
    band = f"{settings.band:g} Hz"
    at = found["attenuation"].sel(band=settings.band)
    if np.isnan(at).any():
        return [f"At {band} nothing is decided: the floor has too little there, or the run is too short for it."]
    cases = [name for name in at["case"].values.tolist() if name != IDEAL]
    level = {(law, case): float(at.sel(law=law, case=case)) for law in LAWS for case in (*cases, IDEAL)}
    said = [
        f"At {band} ideal valves give {level['without', IDEAL]:.1f} dB, and {level['with', IDEAL]:.1f} dB with "
        "linearisation, which makes good their pressure drop."
    ]
    for case in sorted(cases, key=lambda one: level["without", one]):
        name = "all imperfections together" if case == ALL else case
        said.append(f"With {name}: {level['without', case]:.1f} dB, with linearisation {level['with', case]:.1f} dB.")
    clipped = 100.0 * float(found["clipped"].max())
    return [*said, f"Commands are at their limit for up to {clipped:.2g} % of the time."] if clipped else said


def _chart(found: xr.Dataset) -> Figure:
    levels = found["attenuation"]
    panels = {f"{law} linearisation [dB]": curves(levels.sel(law=law), "case") for law in LAWS}
    return lines_chart("Vertical attenuation by imperfection", "third-octave band [Hz]", panels, "x")

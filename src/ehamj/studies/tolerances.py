"""What tolerances cost: one law on many machines, each a little other than the one that it was derived for.

Every machine's values are drawn evenly within their tolerances, those of its isolators for each by itself. The law is
held (`ehamj.scenario.model.Scenario.varied`): it knows the machine that it was derived for and no other. Derived anew
for each machine, it would know what nobody knows, and the scatter would be next to nothing; that may be asked for, to
see the difference, and is said.
"""

import threading
from typing import Annotated, Any, Final, Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.random import Generator
from pydantic import Field

from ehamj.arrays import Array
from ehamj.findings import finite
from ehamj.isolator.actuator import Actuator
from ehamj.labels import table
from ehamj.linear.loop import Loop, linear_under
from ehamj.linear.response import rigid_floor
from ehamj.plots import Figure, Line, lines_chart
from ehamj.result import Result
from ehamj.run.many import simulate_many
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.studies.outcome import Drawing, Outcome, Progress
from ehamj.studies.study import study
from ehamj.studies.variants import BANDS, RECORD_RATE, check_band, derived_law, with_actuators

PERCENTILES: Final = {"median": 50.0, "low": 5.0, "high": 95.0}

Share = Annotated[float, Field(ge=0, lt=0.9)]


class ToleranceSettings(Settings):
    """How many machines, how far they are off, and what is looked at. A tolerance is to both sides, drawn evenly."""

    number: int = Field(100, ge=1, description="machines")
    law: Literal["held", "derived"] = Field("held", description="law held, or derived anew for each machine")
    mass: Share = Field(0.05, description="tolerance of the mass, inertia alike [-]")
    cg: float = Field(0.02, ge=0, description="tolerance of the centre of gravity along x, y and z [m]")
    flow_gain: Share = Field(0.05, description="tolerance of each valve's flow gain [-]")
    valve_frequency: Share = Field(0.05, description="tolerance of each valve's natural frequency [-]")
    bulk_modulus: Share = Field(0.1, description="tolerance of the oil's bulk modulus in each isolator [-]")
    flow_pressure: Share = Field(0.1, description="tolerance of each isolator's flow-pressure coefficient, leakage [-]")
    piston_area: Share = Field(0.005, description="tolerance of each piston's area [-]")
    membrane_stiffness: Share = Field(0.1, description="tolerance of each membrane's stiffness [-]")
    duration: float = Field(10.0, ge=2, description="length of each run [s]")
    band: float = Field(10.0, description="third-octave band that the answers name, of 2, 5, 10, 20, 50, 100 [Hz]")
    seed: int = Field(0, ge=0, description="seed of the draws; machine n is the same however many there are")


OF_ISOLATORS: Final = (
    "flow_gain", "valve_frequency", "bulk_modulus", "flow_pressure", "piston_area", "membrane_stiffness",
)  # fmt: skip
"""Values that each isolator has by itself."""


class Drawn(NamedTuple):
    """One machine: factor on the mass, shift of the CG [m], and factors on each isolator's values (mount, value)."""

    mass: float
    cg: Array
    isolators: Array

    @classmethod
    def of(cls, settings: ToleranceSettings, mounts: int, random: Generator) -> "Drawn":
        """Draw one."""
        wide = np.array([getattr(settings, name) for name in OF_ISOLATORS])
        mass, cg = random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0, 3)
        off = random.uniform(-1.0, 1.0, (mounts, len(OF_ISOLATORS)))
        return cls(1.0 + settings.mass * mass, settings.cg * cg, 1.0 + wide * off)

    def values(self, scenario: Scenario) -> dict[str, Any]:
        """The machine by dotted keys, as `Scenario.varied` takes them."""
        machine, own = scenario.machine, scenario.plant
        isolators: dict[str, Actuator] = {
            name: _scaled(scenario.actuators[mount.actuator], dict(zip(OF_ISOLATORS, factors, strict=True)))
            for name, mount in ((mount.name, mount) for mount in scenario.mount)
            for factors in [self.isolators[own.mounts.index(name)].tolist()]
        }
        return {
            "machine.mass": machine.mass * self.mass,
            "machine.inertia": (self.mass * np.array(machine.inertia)).tolist(),
            "machine.cg": (np.array(machine.cg) + self.cg).tolist(),
            **with_actuators(scenario, isolators),
        }


def _scaled(actuator: Actuator, factors: dict[str, float]) -> Actuator:
    if actuator.rated_flow:
        factors = factors | {"rated_flow": factors["flow_gain"]}  # which states the flow gain
    return actuator.with_values({name: factor * getattr(actuator, name) for name, factor in factors.items()})


@study(
    "tolerances",
    ToleranceSettings,
    "attenuation of many machines within tolerances under one law: median, 5 to 95 %, worst",
    small={"number": 2, "duration": 2.0},
)
def tolerances(scenario: Scenario, settings: ToleranceSettings, progress: Progress) -> Outcome:
    """A scenario without a digital law, and a band that is not looked at, are refused.

    Warns:
        DerivedAnew: where the law is derived anew for each machine.
    """
    derived_law(scenario)
    check_band(settings.band)
    found, drawn = machine_tables(scenario, settings, progress)
    scatter = scatter_of(found)
    held = settings.law == "held"
    return Outcome(
        title="Tolerances",
        question="How well does one law isolate machines that are not quite the one it was made for?",
        answers=tuple(_answers(found, drawn, scatter, settings)),
        tables={"scatter": scatter, "machines": found, "drawn": drawn},
        drawings={
            "attenuation": Drawing(
                f"Vertical attenuation of the centre of gravity of {settings.number} machines (thin), their median, 5 "
                "to 95 % and the machine that the law was derived for.",
                lambda: _chart(found, scatter, settings),
            )
        },
        notes=(
            "The law is held: it was derived for the scenario's machine (or its control.designed_for) and runs on each "
            "machine as it is."
            if held
            else "The law was derived anew for each machine, whose values it so knows exactly: the scatter is not what "
            "tolerances cost. Ask with law = held.",
            "Values are drawn evenly and by themselves; those of an isolator for each one. Floor and instruments are "
            f"the scenario's, {settings.duration:g} s.",
            "The prediction is linear, for a floor that heaves as one body at the bands' centres, without the "
            "instruments' noise.",
        ),
        numbers={
            band: {name: finite(float(scatter[name].sel(band=float(band)))) for name in scatter.data_vars}
            for band in BANDS
        },
    )


def machine_tables(
    scenario: Scenario, settings: ToleranceSettings, progress: Progress
) -> tuple[xr.Dataset, xr.Dataset]:
    """Attenuation of each machine (machine, band), and what was drawn (machine, mount); machine 0 is the scenario's."""
    base = changed(
        scenario,
        {
            "duration": settings.duration,
            "record_rate": max(scenario.record_rate, RECORD_RATE),
            "compare": (),
            "plates": "tied" if all(a.rigid_foot for a in scenario.plant.actuators) else scenario.plates,
        },
    )
    if settings.law == "derived":
        base = base.model_copy(update={"control": base.control.model_copy(update={"designed_for": None})})
    mounts = scenario.plant.mounts
    draws = [Drawn.of(settings, len(mounts), np.random.default_rng((settings.seed, k))) for k in range(settings.number)]
    draws = [Drawn(1.0, np.zeros(3), np.ones_like(draws[0].isolators)), *draws]
    lock, done = threading.Lock(), [0]

    def machine(k: int) -> Scenario:
        values = draws[k].values(base) | {"name": f"machine {k}"} if k else {"name": "as designed"}
        return base.varied(values) if settings.law == "held" else changed(base, values)

    def reduced(result: Result) -> tuple[list[float], list[float], bool, float]:
        own = result.scenario
        levels = result.summary.attenuation_db["z"]
        simulated = [np.nan if (level := levels.get(band)) is None else level for band in BANDS]
        with lock:
            done[0] += 1
            progress(f"machine {done[0]} of {len(draws)}")
        margins = result.summary.margins
        clipped = max(result.summary.saturation["command"].values())
        return simulated, predicted(own), margins is None or margins.stable, clipped

    rows = simulate_many((machine(k) for k in range(len(draws))), reduce=reduced)
    simulated, linear, stable, clipped = map(list, zip(*rows, strict=True))
    number = (list(range(len(draws))), "1", "machine; 0: as designed")
    found = table(
        "machines within tolerances",
        {"machine": number, "band": ([float(band) for band in BANDS], "Hz", "third-octave band")},
        attenuation=(simulated, "dB", "vertical attenuation"),
        predicted=(linear, "dB", "linear prediction"),
        stable=(("machine",), stable, "", "linear machine stable under the law"),
        clipped=(("machine",), clipped, "1", "share of time with a command at its limit"),
    )
    factors = np.array([one.isolators for one in draws])
    drawn = table(
        "what was drawn",
        {"machine": number, "mount": (list(mounts), "", "mount")},
        mass=(("machine",), [one.mass * scenario.machine.mass for one in draws], "kg", "mass"),
        **{
            f"cg_{axis}": (("machine",), [scenario.machine.cg[k] + one.cg[k] for one in draws], "m", f"CG in {axis}")
            for k, axis in enumerate("xyz")
        },
        **{name: (factors[:, :, k], "1", f"factor on {name.replace('_', ' ')}") for k, name in enumerate(OF_ISOLATORS)},
    )
    return found, drawn


def predicted(scenario: Scenario) -> list[float]:
    """Linear attenuation of heave at the bands' centres [dB]."""
    loop = Loop.of(scenario, scenario.controller())
    hertz = np.array([float(band) for band in BANDS])
    answer = rigid_floor(
        linear_under(scenario.plant, loop.law if loop else None), hertz, loop, ("cg_displacement z",), ("z",)
    ).response
    return [float(level) for level in -20.0 * np.log10(np.abs(answer.ravel()))]


def scatter_of(found: xr.Dataset) -> xr.Dataset:
    """Per band the attenuation as designed, and of the machines median, 5 and 95 %, worst and best [dB]."""
    levels = found["attenuation"]
    many, linear = levels.isel(machine=slice(1, None)), found["predicted"].isel(machine=slice(1, None))
    columns = {"designed": (levels.isel(machine=0).values, "dB", "as designed")}
    words = {"median": "median", "low": "5 %", "high": "95 %"}
    for name, share in PERCENTILES.items():
        columns[name] = (np.percentile(many.values, share, axis=0), "dB", words[name])
    columns |= {
        "worst": (many.min("machine", skipna=False).values, "dB", "worst"),
        "best": (many.max("machine", skipna=False).values, "dB", "best"),
        "predicted": (np.median(linear.values, axis=0), "dB", "median of the linear prediction"),
    }
    band = (found["band"].values.tolist(), "Hz", "third-octave band")
    return table("attenuation within tolerances", {"band": band}, **columns)


def _answers(found: xr.Dataset, drawn: xr.Dataset, scatter: xr.Dataset, settings: ToleranceSettings) -> list[str]:
    at = {name: float(scatter[name].sel(band=settings.band)) for name in scatter.data_vars}
    number, band, law = settings.number, f"{settings.band:g} Hz", f"the law {settings.law}"
    law = "the law held" if settings.law == "held" else "the law derived anew for each"
    if np.isnan(at["median"]):
        answers = [f"At {band} nothing is decided: the floor has too little there, or the run is too short for it."]
    else:
        answers = [
            f"At {band}, {law}: {number} machines are isolated by {at['median']:.1f} dB in the median, "
            f"{at['low']:.1f} to {at['high']:.1f} dB from 5 to 95 %, {at['worst']:.1f} dB at worst; the machine as "
            f"designed by {at['designed']:.1f} dB.",
            f"The linear prediction has {at['predicted']:.1f} dB there in the median.",
        ]
        if number >= 10:
            answers.append(_causes(found, drawn, settings))
    shaky = int((~found["stable"]).sum())
    answers.append(
        f"Under the law {shaky} of the {number} machines are unstable." if shaky else "Every machine is stable."
    )
    if (clipped := 100 * float(found["clipped"].max())) > 0.0:
        answers.append(f"Commands are at their limit for up to {clipped:.2g} % of the time.")
    return answers


def _causes(found: xr.Dataset, drawn: xr.Dataset, settings: ToleranceSettings) -> str:
    """Which value goes with the attenuation most, by rank correlation; of the isolators' values their means."""
    from scipy.stats import spearmanr

    level = found["attenuation"].sel(band=settings.band).values[1:]
    values = {name: drawn[name].mean("mount").values[1:] for name in OF_ISOLATORS if getattr(settings, name)}
    values |= {"mass": drawn["mass"].values[1:]} if settings.mass else {}
    ranks = {name: float(spearmanr(one, level).statistic) for name, one in values.items()}
    name = max(ranks, key=lambda one: abs(ranks[one]), default="")
    if not name or abs(ranks[name]) < 0.3:
        return "No single value decides how well a machine is isolated (all rank correlations are below 0.3)."
    less = "less" if ranks[name] < 0.0 else "more"
    words = f"the {name.replace('_', ' ')}" + ("" if name == "mass" else ", mean of the isolators,")
    return f"It goes most with {words} of which more means {less} attenuation (rank correlation {ranks[name]:.2f})."


def _chart(found: xr.Dataset, scatter: xr.Dataset, settings: ToleranceSettings) -> Figure:
    hertz = found["band"].values
    lines = [
        Line("each machine" if k == 0 else "", hertz, row, 6, width=0.4)
        for k, row in enumerate(found["attenuation"].values[1:])
    ]
    for name, label, color, dash in (
        ("low", "5 %", 0, 1),
        ("high", "95 %", 0, 1),
        ("worst", "worst", 1, 0),
        ("predicted", "linear, median", 3, 2),
        ("designed", "as designed", 2, 0),
        ("median", "median", 0, 0),
    ):
        lines.append(Line(label, hertz, scatter[name].values, color, dash, width=2.0 if dash == 0 else 1.4))
    title = f"{settings.number} machines within tolerances, law {settings.law}"
    return lines_chart(title, "third-octave band [Hz]", {"vertical attenuation [dB]": lines}, "x")

"""Merits of runs: those of `ehamj.simulate` to the digit, whatever runs beside them; failures by themselves."""

import math
import warnings
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor

import pytest

from ehamj.errors import InputError
from ehamj.merits.applied import scenario_of
from ehamj.merits.merit import SOURCES, Design, Failed, Found, Machine, merit
from ehamj.merits.run import Runs
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario

MASS, OIL = "machine.mass", "actuators.isolator.bulk_modulus"
BASE = load_scenario(
    "vc-c-floor",
    ["duration=0.6", "compare=[]", "plates=tied", "record_rate=2000", "control.kind=combined", "engine=small-motion"],
)
MACHINE = Machine(BASE)
RUNS = Runs()
DESIGNS = [Design(k, {MASS: 4000.0 + 40.0 * k}) for k in range(3)]
ALONE = (
    "run.attenuation_db.z.63",
    "run.attenuation_db.z.40",
    "run.attenuation_db.ry.50",
    "run.attenuation_db.x.50",
    "run.attenuation_at_db.feet.z.40",
    "run.attenuation_at_db.spindle-nose.z.50",
    "run.saturation.command.front-left",
    "run.oil.mean_power_w",
    "run.oil.peak_flow_m3_s",
    "run.rms.valve_command.front-left",
    "run.peak.cg_velocity.z",
    "run.peak.foot_acceleration.rear-left.z",
    "run.rms.chamber_pressure.rear-left.1",
    "run.margins.disk",
    "run.margins.motions.heave.phase_deg",
    "run.margins.stable",
    "run.timing.steps",
    "run.timing.simulated_s",
    "run.at_limit.command.first_s",
)
"""Found by themselves."""
WHOLE = ("run.criterion.machine.z.margin_db", "run.third_octave_velocity.machine.z.50", "run.complete")
"""Taken from a whole summary."""


def in_summary(machine: Machine, design: Design, names: tuple[str, ...]) -> dict[str, float]:
    """The numbers of a design's own run, judged whole."""
    summary = simulate(scenario_of(machine, design.values)).summary.to_dict()

    def at(table: object, path: str) -> float:
        if not path:
            return float(table) if isinstance(table, bool | int | float) else math.nan
        for key in table if isinstance(table, Mapping) else ():
            if path == key or path.startswith(f"{key}."):
                return at(table[key], path[len(key) + 1 :])
        return math.nan

    return {name: at(summary, name.removeprefix("run.")) for name in names}


def same(one: Found, other: Found) -> None:
    """Equal to the bit; NaN where the other is."""
    assert not isinstance(one, Failed), one
    assert not isinstance(other, Failed), other
    assert {name: repr(value) for name, value in one.items()} == {name: repr(value) for name, value in other.items()}


@pytest.mark.parametrize("engine", ["small-motion", "mujoco"])
def test_numbers_are_those_of_the_summary_to_the_digit(engine: str) -> None:
    machine = Machine(BASE.model_copy(update={"engine": engine}))
    expected = in_summary(machine, DESIGNS[1], (*ALONE, *WHOLE))
    assert sum(map(math.isfinite, expected.values())) >= len(expected) - 3
    names = ALONE if engine == "small-motion" else (*ALONE, *WHOLE)
    same(RUNS.evaluate(machine, DESIGNS[:2], names)[1], {name: expected[name] for name in names})
    if engine == "small-motion":
        same(RUNS.evaluate(machine, DESIGNS[1:2], WHOLE)[0], {name: expected[name] for name in WHOLE})


def test_results_are_equal_to_the_bit_in_any_company() -> None:
    names = ALONE[:13]
    together = RUNS.evaluate(MACHINE, DESIGNS, names)
    for design, found in zip(DESIGNS, together, strict=True):
        same(RUNS.evaluate(MACHINE, [design], names)[0], found)
    with ThreadPoolExecutor(2) as pool:
        halves = pool.map(lambda own: RUNS.evaluate(MACHINE, own, names), (DESIGNS[1:], DESIGNS[:1]))
        for found, other in zip([*next(halves), *next(halves)], [*together[1:], together[0]], strict=True):
            same(found, other)


def test_designs_that_fail_say_why_and_stop_nothing() -> None:
    tilting = Machine(
        BASE.varied({"ground": {"kind": "sine", "dof": "ry", "amplitude": 1e-4, "frequency": 3.0, "fade_in": 0.05}})
    )
    designs = [
        DESIGNS[0],
        Design(1, {MASS: -1.0}),
        Design(2, {"ground.amplitude": 2e-3}),
        Design(3, {"machine.cg": [3.0, 0.0, 0.6]}),
        Design(4, {"no.such": 1.0}),
        DESIGNS[2],
    ]
    names = ("run.peak.cg_velocity.z", "run.oil.mean_power_w")
    found = RUNS.evaluate(tilting, designs, names)
    reasons = [one.reason if isinstance(one, Failed) else "" for one in found]
    assert reasons[1] == "machine.mass = -1.0: must be greater than 0"
    assert reasons[2].startswith("simulation failed at ")
    assert "it turned by more than 1 mrad" in reasons[2]
    assert reasons[3].startswith("machine: cg = [3.0, 0.0, 0.6] lies outside")
    assert "unknown key" in reasons[4]
    same(RUNS.evaluate(tilting, [DESIGNS[2]], names)[0], found[5])
    same(RUNS.evaluate(tilting, [DESIGNS[0]], names)[0], found[0])


def test_a_law_is_held_or_derived_as_the_machine_says() -> None:
    """Its margins tell: what is derived for weaker oil has others than what is held."""
    weak, name = [Design(0, {OIL: 0.8 * BASE.actuators["isolator"].bulk_modulus})], "run.margins.disk"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        held, derived = (RUNS.evaluate(Machine(BASE, law), weak, [name])[0] for law in ("held", "derived"))
    assert not isinstance(held, Failed)
    assert not isinstance(derived, Failed)
    assert abs(held[name] - derived[name]) > 1e-3
    anew = simulate(BASE.model_copy(update=_weaker())).summary["margins"]["disk"]
    assert derived[name] == anew


def _weaker() -> dict[str, object]:
    actuator = BASE.actuators["isolator"]
    return {"actuators": {"isolator": actuator.model_copy(update={"bulk_modulus": 0.8 * actuator.bulk_modulus})}}


def test_flow_and_power_are_those_of_the_histories() -> None:
    result = simulate(scenario_of(MACHINE, DESIGNS[0].values))
    found = RUNS.evaluate(MACHINE, DESIGNS[:1], ["run.flow.rms", "run.flow.peak", "run.power"])[0]
    assert not isinstance(found, Failed)
    passed = 0.5 * abs(result.dataset["chamber_flow"]).sum(("mount", "chamber"))
    assert found["run.flow.rms"] == pytest.approx(float((passed**2).mean() ** 0.5), rel=1e-12)
    assert found["run.flow.peak"] == float(passed.max())
    assert found["run.power"] == result.summary["oil"]["mean_power_w"]


def test_a_class_whose_bands_a_short_run_does_not_know_is_not_kept() -> None:
    """Nothing is known at 1 Hz of 0.6 s: no distance, rather than an endless one that any limit takes for kept."""
    found = RUNS.evaluate(MACHINE, DESIGNS[:1], ["run.below.VC-F.z"])[0]
    assert not isinstance(found, Failed)
    assert math.isnan(found["run.below.VC-F.z"])


def test_all_numbers_of_the_summary_are_merits_and_chance_is_none() -> None:
    names = RUNS.merits(MACHINE)
    assert {*ALONE, *WHOLE} <= set(names)
    assert names["run.attenuation_db.z.63"].unit == "dB"
    assert names["run.rms.stroke.front-left"].unit == "m"
    assert names["run.oil.peak_flow_m3_s"].unit == "m³/s"
    assert not any("wall_s" in name or "stepping_s" in name for name in names)
    with pytest.raises(InputError, match=r"merit 'run.attenuation_db.z.11': no such merit of this machine"):
        merit(MACHINE, "run.attenuation_db.z.11")
    assert isinstance(SOURCES["run"], Runs)


def test_the_scenario_that_shows_what_there_is_may_be_of_any_length() -> None:
    brief: Scenario = BASE.varied({"duration": 0.002})
    assert "run.oil.volume_m3" in Runs().merits(Machine(brief))


def test_a_band_that_runs_are_too_short_for_is_refused_with_the_way_out() -> None:
    """The 1 Hz band is 0.23 Hz wide: four times its reciprocal, and the second that does not count."""
    with pytest.raises(InputError, match=r"its 1 Hz band needs duration = 18\.\d s, runs take 0\.6 s"):
        merit(MACHINE, "run.attenuation_db.z.1")
    with pytest.raises(InputError, match=r"its 1 Hz band needs .*with criteria\.low_frequency = 'classic' it has none"):
        merit(Machine(BASE.varied({"criteria.low_frequency": "flat"})), "run.below.VC-F.z")
    with pytest.raises(InputError, match=r"its 315 Hz band ends above half of record_rate = 500 Hz"):
        merit(Machine(BASE.model_copy(update={"record_rate": 500.0})), "run.attenuation_db.z.315")

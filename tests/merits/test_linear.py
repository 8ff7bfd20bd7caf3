"""Merits of actuators and passive machines against the differentiated model and the paper's own figures."""

import numpy as np
import pytest

from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.linear.response import rigid_floor
from ehamj.merits.applied import scenario_of
from ehamj.merits.catalogue import SOURCES
from ehamj.merits.merit import Design, Failed, Machine, merit
from ehamj.paper.merits import figures_of_merit
from ehamj.scenario.load import load_scenario

BARE = ["control={kind='passive'}", "compare=[]"]
UPRIGHT = Machine(load_scenario("vc-c-floor", BARE))
LEVEL = Machine(load_scenario("six-directions", BARE))
SOFT = Machine(load_scenario("vc-c-floor", [*BARE, "actuators.isolator.foot_stiffness=2e9"]))
VARIED = {
    "machine.mass": (3300.0, 4700.0), "machine.cg.2": (0.6, 1.1), "supply.pressure": (150e5, 230e5),
    "mount.front-left.actuator.bulk_modulus": (4e8, 9e8), "mount.2.actuator.membrane_stiffness": (4e8, 8e8),
}  # fmt: skip


def drawn(number: int, seed: int = 1) -> list[Design]:
    random = np.random.default_rng(seed)
    return [Design(k, {key: float(random.uniform(*ends)) for key, ends in VARIED.items()}) for k in range(number)]


def names_of(source: str, machine: Machine) -> list[str]:
    return list(SOURCES[source].merits(machine))


@pytest.mark.parametrize("machine", [UPRIGHT, LEVEL, SOFT], ids=["upright", "level too", "on soft feet"])
def test_passive_merits_are_those_of_the_differentiated_model(machine: Machine) -> None:
    """Its own route for the peak, static stiffness and attenuation: every force and floor through the states."""
    design = drawn(3)[2]
    found = SOURCES["passive"].evaluate(machine, [design], names_of("passive", machine))[0]
    assert not isinstance(found, Failed)
    model = linear_model(scenario_of(machine, design.values).plant)
    by_name = sorted(mode.frequency for mode in modes(model) if mode.machine_moves)[:6]
    ours = sorted(value for name, value in found.items() if name.startswith("passive.frequency."))
    np.testing.assert_allclose(ours, by_name, rtol=1e-6)
    for axis in "xyz":
        push = model.response([1e-7], [f"cg_displacement {axis}"], [f"cg_force {axis}"]).real.item()
        assert found[f"passive.static_stiffness.{axis}"] == pytest.approx(1.0 / push, rel=1e-5)
        hertz = 1000.0 * 10 ** (-2.0 + 0.1 * (np.arange(8) - 3.5) / 8)
        answer = rigid_floor(model, hertz, None, (f"cg_displacement {axis}",), (axis,)).response.ravel()
        level = -10 * np.log10((np.abs(answer) ** 2).mean())
        assert found[f"passive.attenuation.{axis}.10"] == pytest.approx(level, abs=1e-6)
        swept = rigid_floor(model, np.geomspace(10, 1000, 2000), None, (f"cg_displacement {axis}",), (axis,)).response
        assert found[f"passive.peak.{axis}"] == pytest.approx(20 * np.log10(np.abs(swept).max()), abs=0.1)


def test_a_symmetric_machine_has_the_same_in_both_planes() -> None:
    values = {"machine.inertia.0": 2500.0, "machine.inertia.1": 2500.0, "footprint.x": 1.4, "footprint.y": 1.4}
    found = SOURCES["passive"].evaluate(UPRIGHT, [Design(0, values)], names_of("passive", UPRIGHT))[0]
    assert not isinstance(found, Failed)
    for name in ("frequency.{}-about-{}", "damping_ratio.{}-about-{}"):
        for which in ("lower", "upper"):
            one, two = (found["passive." + name.format(which, axis)] for axis in "xy")
            assert one == pytest.approx(two, rel=1e-9)


def test_machines_without_closed_forms_have_the_same_merits_one_at_a_time() -> None:
    """A pump that gives way changes nothing slow about the machine itself; then nothing at all differs."""
    pumped = Machine(load_scenario("vc-c-floor", [*BARE, "actuators.isolator.overlap=[0.2,0.2,0.2,0.2]"]))
    source, names = SOURCES["passive"], names_of("passive", UPRIGHT)
    assert not source.notes(UPRIGHT)
    assert "one design at a time" in source.notes(pumped)[0]
    assert "overlap" in source.notes(pumped)[0]
    one, other = (source.evaluate(machine, drawn(1), names)[0] for machine in (UPRIGHT, pumped))
    assert not isinstance(one, Failed)
    assert not isinstance(other, Failed)
    for name in names:
        assert other[name] == pytest.approx(one[name], rel=1e-5, abs=1e-6), name


@pytest.mark.parametrize("source", ["actuator", "passive"])
def test_a_design_is_the_same_to_the_bit_in_any_company(source: str) -> None:
    many, names = drawn(40), names_of(source, UPRIGHT)
    together = SOURCES[source].evaluate(UPRIGHT, many, names)
    company = [many[7], Design(90, {**many[0].values, "machine.mass": -1.0}), many[3], many[31]]
    found = SOURCES[source].evaluate(UPRIGHT, company, names)
    assert [found[0], found[2], found[3]] == [together[7], together[3], together[31]]
    assert SOURCES[source].evaluate(UPRIGHT, [many[12]], names) == [together[12]]
    assert isinstance(found[1], Failed)


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"machine.mass": 0.0}, r"machine.mass = 0: must be above 0"),
        ({"mount.0.actuator.piston_area": float("nan")}, r"mount.0.actuator.piston_area = nan: must be"),
        ({"supply.pressure": 1e3, "supply.tank_pressure": 2e3}, "must be above tank_pressure = 2000 Pa"),
        ({"actuators.isolator.membrane_stiffness": 1e4}, "no rest in its cylinders"),
        ({"actuators.isolator.foot_stiffness": 1e9}, "must be finite in all designs, or infinite in all"),
        ({"machine.masss": 1.0}, "masss"),
    ],
)
def test_an_impossible_design_fails_alone_and_says_why(values: dict[str, float], reason: str) -> None:
    sound = drawn(1)[0]
    found = SOURCES["passive"].evaluate(UPRIGHT, [sound, Design(1, values)], ["passive.tipping_margin"])
    assert not isinstance(found[0], Failed)
    assert isinstance(found[1], Failed)
    assert reason in found[1].reason
    assert "\n" not in found[1].reason


def test_an_isolators_own_value_goes_before_that_of_its_kind() -> None:
    names, kind = names_of("passive", UPRIGHT), "actuators.isolator.bulk_modulus"
    each = {f"mount.{name}.actuator.bulk_modulus": 6e8 for name in UPRIGHT.scenario.plant.mounts}
    of_each, of_kind = SOURCES["passive"].evaluate(UPRIGHT, [Design(0, {kind: 9e8, **each})], names), (
        SOURCES["passive"].evaluate(UPRIGHT, [Design(0, {kind: 6e8})], names)
    )  # fmt: skip
    assert of_each == of_kind


@pytest.mark.parametrize("damped", [0.2, 1.0, 30.0], ids=["little leakage", "as it is", "overdamped"])
def test_figures_of_actuators_are_those_of_the_paper(damped: float) -> None:
    values = {**drawn(1)[0].values, "actuators.isolator.flow_pressure": damped * 6.6e-11}
    values = {key: value for key, value in values.items() if not key.startswith("mount.")}
    found = SOURCES["actuator"].evaluate(UPRIGHT, [Design(0, values)], names_of("actuator", UPRIGHT))[0]
    assert not isinstance(found, Failed)
    plant = scenario_of(UPRIGHT, values).plant
    paper = figures_of_merit(plant.actuators[0], plant.total_mass / 4)
    pairs = {
        "hydraulic_frequency": paper.omega_h_hz, "hydraulic_damping": paper.delta_h, "gain": paper.gain,
        "resonance_frequency": paper.resonance_hz, "resonance_damping": paper.resonance_damping,
        "gain_margin": paper.gain_margin_db, "phase_crossover": paper.phase_crossover_hz,
        "gain_crossover": paper.gain_crossover_hz, "phase_margin": paper.phase_margin_deg,
        "bandwidth": paper.bandwidth_hz, "velocity_gain": paper.velocity_gain, "valve_ratio": paper.valve_ratio,
        "velocity_gain_limit": paper.velocity_gain_limit, "merritt_limit": paper.merritt_limit,
        "hydraulic_stiffness": paper.hydraulic_stiffness, "stiffness_ratio": paper.stiffness_ratio,
        "break_frequency": paper.break_frequency / (2 * np.pi),
    }  # fmt: skip
    for name, value in pairs.items():
        expected = np.nan if value is None else value
        assert found[f"actuator.isolator.{name}"] == pytest.approx(expected, rel=1e-7, nan_ok=True), name


def test_merits_have_units_and_a_wrong_name_is_refused() -> None:
    assert merit(UPRIGHT, "passive.static_stiffness.z").unit == "N/m"
    with pytest.raises(Exception, match=r"passive.frequency.heave"):
        merit(UPRIGHT, "passive.frequency.heav")

"""Every registered architecture: it runs alone and in a sum, a scenario can be compared with it, a design knows it."""

from typing import Any, Literal

import numpy as np
import pytest

from ehamj.control import Controller
from ehamj.control.blocks import Block
from ehamj.control.channels import MountChannels
from ehamj.control.kinds import ARCHITECTURES
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.control.settings import DigitalSettings
from ehamj.control.windup import AntiWindup, anti_windup_gain
from ehamj.design.kinds import DESIGNABLE
from ehamj.errors import InputError
from ehamj.plant.plant import Plant
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.synthesis.kinds import CONTROLS, STANDARD, SYNTHESES

GIVEN: dict[str, dict[str, Any]] = {
    "resonant": {"lines": [25.0, 50.0]},
    "adaptive": {"lines": [25.0, 50.0]},
    "levelling": {"time": 0.02},
}
"""What an architecture without defaults is given, and one that is too slow for a short run."""
FLOOR = {"kind": "multisine", "frequencies": [20.0, 50.0], "velocities": [2e-6]}


def stated(kind: str) -> dict[str, Any]:
    return {"kind": kind, **GIVEN.get(kind, {})}


@pytest.fixture(params=list(ARCHITECTURES))
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_it_runs_alone(kind: str) -> None:
    scenario = parse_scenario({"plates": "tied", "duration": 0.02, "ground": FLOOR, "control": stated(kind)})
    run = simulate(scenario)
    assert np.abs(run.dataset["valve_command"]).max() > 0


def test_in_a_sum_its_commands_are_those_alone_beside_nothing(kind: str) -> None:
    """Beside a feedforward, which leaves every other law as it is."""
    scenario = parse_scenario({"control": {"kind": "combined", "parts": [{"kind": "feedforward"}, stated(kind)]}})
    law = scenario.controller()
    assert law is not None
    total = np.zeros((4, len(law.inputs)), complex)
    for part in ({"kind": "feedforward"}, stated(kind)):
        own = parse_scenario({"control": part}).controller()
        assert own is not None
        total[:, [law.inputs.index(name) for name in own.inputs]] += own.response(17.0)[0]
    np.testing.assert_allclose(law.response(17.0)[0], total, rtol=0, atol=1e-9 * np.abs(total).max())


def test_a_scenario_is_compared_with_it_unless_something_must_be_stated(kind: str) -> None:
    if kind in STANDARD:
        variant = parse_scenario({"name": "a", "compare": [kind]}).variant(kind)
        assert (variant.control.kind, variant.name) == (kind, f"a, {kind}")
        assert kind in DESIGNABLE
    else:
        with pytest.raises(InputError, match=f"compare.0 = '{kind}': must be .*'combined'"):
            parse_scenario({"compare": [kind]})


def test_its_resolved_settings_are_read_again(kind: str, tmp_path: Any) -> None:
    scenario = parse_scenario({"control": {"kind": "combined", "parts": [stated(kind)], "rate": 5000.0}})
    path = tmp_path / "scenario.toml"
    path.write_text(scenario.to_toml(), encoding="utf-8")
    assert load_scenario(path).control == scenario.control


def test_a_loop_it_names_is_a_field_whose_crossing_counts(kind: str) -> None:
    settings = ARCHITECTURES[kind].model_validate(GIVEN.get(kind, {}))
    plant = parse_scenario({}).plant
    whole = settings.controller(plant, IDEAL).response(30.0)
    for name, loop in settings.loops(plant).items():
        less = settings.model_copy(update={name: loop.model_copy(update={"crossing": 0.5 * loop.crossing})})
        found = less.controller(plant, IDEAL).response(30.0)
        assert np.abs(found - whole).max() > 0.01 * np.abs(whole).max(), name


def test_passive_signals_a_sum_and_a_file_are_controls_too() -> None:
    assert set(CONTROLS) - set(ARCHITECTURES) == {"passive", "open-loop", "combined", *SYNTHESES, "law"}


# --- a law states its anti-windup ---------------------------------------------------------------------------------


class Integral(DigitalSettings):
    """An integrator of each stroke, with an anti-windup that is given."""

    kind: Literal["integral"] = "integral"

    def law(self, plant: Plant, extra: int = 0, taken: float = 0.01, answers: float = 0.0, **windup: Any) -> Controller:
        """With ``extra`` inputs for what the valves did not get, of which the states take a share."""
        n = len(plant.mounts)
        B, D = np.hstack([np.eye(n), taken * np.eye(n)[:, :extra]]), np.zeros((n, n + extra))
        D[:, n:] = answers
        block = Block(np.eye(n), B, np.eye(n), D)
        return self.digital(block, MountChannels.of(plant).strokes, plant, sensors=IDEAL, **windup)

    def controller(self, plant: Plant, sensors: Sensors) -> Controller:
        return self.law(plant, anti_windup=AntiWindup.NONE)


@pytest.fixture(scope="module")
def plant() -> Plant:
    return parse_scenario({}).plant


def test_a_law_without_a_stated_anti_windup_is_refused(plant: Plant) -> None:
    with pytest.raises(TypeError, match="anti_windup"):
        Integral().law(plant)


def test_none_can_be_stated(plant: Plant) -> None:
    assert Integral().law(plant, anti_windup=AntiWindup.NONE).anti_windup is None


def test_a_matrix_can_be_stated(plant: Plant) -> None:
    np.testing.assert_array_equal(Integral().law(plant, anti_windup=0.1 * np.eye(4)).anti_windup, 0.1 * np.eye(4))


def test_inputs_after_those_measured_can_be_it(plant: Plant) -> None:
    law = Integral().law(plant, extra=4, anti_windup=AntiWindup.INPUTS)
    np.testing.assert_array_equal(law.anti_windup, 0.01 * np.eye(4))
    np.testing.assert_array_equal(law.B, np.eye(4))


def test_one_that_swings_up_while_limited_is_refused(plant: Plant) -> None:
    with pytest.raises(InputError, match=r"control\.recovery = 0\.15 s: too slow"):
        Integral().law(plant, extra=4, taken=-0.01, anti_windup=AntiWindup.INPUTS)


def test_dual_lq_can_be_it_over_the_time_of_recovery(plant: Plant) -> None:
    law = Integral(recovery=0.3).law(plant, anti_windup=AntiWindup.DUAL_LQ)
    np.testing.assert_array_equal(law.anti_windup, anti_windup_gain(np.eye(4), np.eye(4), 1e-4, 0.3))


@pytest.mark.parametrize("choice", [AntiWindup.NONE, AntiWindup.DUAL_LQ])
def test_inputs_that_the_stated_choice_does_not_have_are_refused(plant: Plant, choice: AntiWindup) -> None:
    with pytest.raises(ValueError, match="has 8 inputs, not 4"):
        Integral().law(plant, extra=4, anti_windup=choice)


def test_a_choice_without_its_inputs_is_refused(plant: Plant) -> None:
    with pytest.raises(ValueError, match="has 4 inputs, not 8"):
        Integral().law(plant, anti_windup=AntiWindup.INPUTS)


def test_what_was_lost_may_not_be_answered_at_once(plant: Plant) -> None:
    with pytest.raises(ValueError, match="answers at once"):
        Integral().law(plant, extra=4, answers=0.1, anti_windup=AntiWindup.INPUTS)

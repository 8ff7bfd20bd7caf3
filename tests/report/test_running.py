"""What describes an actuator shows what ran."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from ehamj.memory import isolators
from ehamj.mujoco.model import build_model
from ehamj.replay.about import _parameters
from ehamj.report.sections.inputs import inputs
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario


def rated() -> Scenario:
    """1e-4 m³/s at 35 bar over one edge, which is also Δp₀ of 70 bar: K_Q = 1e-4/20 = 5e-6 m³/s/mA."""
    return parse_scenario({"actuators": {"isolator": {"rated_flow": 1e-4}}})


def row(scenario: Scenario, key: str) -> str:
    """A row of the report's table of the actuator, as text."""
    shown = cast(
        Any,
        SimpleNamespace(
            results={"own": SimpleNamespace(scenario=scenario, summary=SimpleNamespace(warnings=[], levels={}))}
        ),
    )
    table = next(table for table in inputs(shown).tables if table.title == "Actuator isolator")
    return next(" ".join(map(str, cells)) for cells in table.rows if f"<code>{key}</code>" in str(cells[0]))


def test_the_reports_table_has_the_flow_gain_of_the_model() -> None:
    gain = isolators(build_model(rated().plant, 1e-4))["flow_gain"][0]
    assert gain == pytest.approx(5e-6, rel=1e-12)
    found = row(rated(), "flow_gain")
    assert "5 × 10⁻⁶ m³/s/mA" in found
    assert "given" in found
    assert "paper" not in found


def test_the_stated_rated_flow_is_shown_too() -> None:
    assert "given" in row(rated(), "rated_flow")
    assert "paper" in row(parse_scenario({}), "flow_gain")


def test_the_replays_table_has_it_too() -> None:
    text = "".join(_parameters({"own": cast(Any, SimpleNamespace(scenario=rated()))}))
    assert "| flow gain | K_Q | 5e-6 m³/s/mA | given |" in text

"""An identification file: what is written amiss is told, and what to write."""

import tomllib
from typing import Any

import pytest

from ehamj.errors import InputError
from ehamj.identification.file import load_identify

TEST = """
[[test]]
name = "gauge"
kind = "static"
load = [{}, {}]
reading = { "stroke front-left" = [0.0, 1e-6] }
"""


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("machine.mass = {}", "machine.mass"),
        ("actuators.isolator.flow_gain = { bounds = [1e-6, 4e-6] }", "actuators.isolator.flow_gain"),
    ],
)
def test_a_key_without_quotes_is_told_so(written: str, meant: str) -> None:
    with pytest.raises(InputError, match=f'parameters: a key with dots stands in quotes: "{meant}"'):
        load_identify(tomllib.loads(f"[parameters]\n{written}\n{TEST}"))
    key, _, rest = written.partition(" = ")
    assert list(load_identify(tomllib.loads(f'[parameters]\n"{key}" = {rest}\n{TEST}')).parameters) == [meant]


@pytest.mark.parametrize(
    "table",
    [
        {"test": [{"name": "sweep", "kind": "record", "band": [400.0, 1.0]}]},
        {"plan": {"candidates": [{"kind": "shaker", "band": [400.0, 1.0]}]}, "test": []},
    ],
)
def test_a_band_that_falls_is_refused(table: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"\.band = \[400\.0?, 1\.0?\]: the first must be below the second"):
        load_identify({"scenario": "recorded", "parameters": {"machine.mass": {}}, **table})

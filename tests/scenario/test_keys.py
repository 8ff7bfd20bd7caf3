"""Dotted keys as a user writes them."""

import pytest

from ehamj.errors import InputError
from ehamj.scenario.keys import override, parts_of


@pytest.mark.parametrize(
    ("key", "parts"),
    [
        ("machine.mass", ["machine", "mass"]),
        ('vary."machine.mass".low', ["vary", "machine.mass", "low"]),
        ("vary.'machine.cg.2' . off", ["vary", "machine.cg.2", "off"]),
        ("points.o'clock.0", ["points", "o'clock", "0"]),  # a quote that closes nothing is part of the name
        ('points."nose', ["points", '"nose']),
    ],
)
def test_parts_in_quotes_hold_dots(key: str, parts: list[str]) -> None:
    assert parts_of(key) == parts


def test_a_study_s_spread_is_changed_within_its_key() -> None:
    table = {"vary": {"machine.mass": {"tolerance": 0.1}}}
    override(table, 'vary."machine.mass".tolerance=0.05')
    assert table == {"vary": {"machine.mass": {"tolerance": 0.05}}}


@pytest.mark.parametrize("value", ["'rig", '"rig', "[1, 2", '{kind="pid"', "[one, two]"])
def test_a_value_that_is_not_closed_is_no_string(value: str) -> None:
    table: dict[str, object] = {}
    with pytest.raises(InputError, match=r"^--set .*name=.*: .* begins as a TOML value and is none"):
        override(table, f"name={value}")
    assert table == {}


@pytest.mark.parametrize(("value", "found"), [('"[rig"', "[rig"), ("it's", "it's"), ("[1, 2]", [1, 2])])
def test_a_value_is_toml_or_a_string(value: str, found: object) -> None:
    table: dict[str, object] = {}
    override(table, f"name={value}")
    assert table == {"name": found}

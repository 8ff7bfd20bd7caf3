"""Dotted keys as a user writes them."""

import pytest

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

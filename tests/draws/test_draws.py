"""A small part of `make draws`; and that its summary sees what it is there to see."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from draws.__main__ import told
from draws.summary import summary
from draws.trial import KINDS, trial


def test_what_was_drawn_is_found_as_well_as_it_can_be(tmp_path: Path) -> None:
    found = trial("few", 1, 0, tmp_path)
    for key in KINDS["few"].keys:
        value, deviation, status = found["found"][key]
        assert status == "identified"
        assert abs(value - found["true"][key]) < 4.0 * deviation
        assert 0.9 < deviation / found["bound"][key] < 1.2
    assert found["converged"]


def of_draws(errors: np.ndarray, **more: Any) -> list[dict[str, Any]]:
    """Trials whose errors are as many deviations of one value."""
    plain = {"kind": "values", "seconds": 1.0, "true": {"a": 3.0}, "bound": {"a": 0.1}, "options": {}}
    return [
        {**plain, "number": k, "found": {"a": [3.0 + 0.1 * error, 0.1, "identified"]}, **more}
        for k, error in enumerate(errors)
    ]


@pytest.mark.parametrize(
    ("size", "more", "missed"),
    [
        (1.0, {}, []),
        (1.5, {}, ["RMS of 0.8 to 1.25", "98 % within 3 deviations"]),
        (0.5, {}, ["RMS of 0.8 to 1.25"]),
        (1.0, {"bound": {"a": 0.05}}, ["deviations within 1.5 times the least possible (0.0 % are)"]),
        (1.0, {"options": {"air": 0.01}, "justified": []}, ["found in 95 %"]),
        (1.0, {"justified": ["air"]}, ["false in 5 % at most"]),
    ],
    ids=["honest", "too narrow", "too wide", "wider than possible", "not found", "false"],
)
def test_the_summary_says_what_is_missed(size: float, more: dict[str, Any], missed: list[str]) -> None:
    errors = size * np.random.default_rng(0).standard_normal(400)
    lines = [line.partition("MISSED: ")[2] for line in summary(of_draws(errors, **more)) if "MISSED" in line]
    assert lines == missed


def test_a_value_without_a_number_is_counted_apart() -> None:
    lost = of_draws(np.zeros(1), found={"a": [None, None, "unidentifiable"]})
    (line,) = (line for line in summary([*of_draws(np.ones(3)), *lost]) if line.strip().startswith("a "))
    assert line.split()[:5] == ["a", "1.00", "100.0", "%", "1.00"]
    assert line.split()[5] == "1"


def test_a_line_that_was_cut_off_is_drawn_again(tmp_path: Path) -> None:
    path = tmp_path / "draws.jsonl"
    path.write_text('{"number": 1}\n{"number"')
    assert told(path) == [{"number": 1}]
    assert told(path) == [{"number": 1}]

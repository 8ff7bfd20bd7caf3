"""A kernel is what its machine code depends on: a change of that changes its identity, and no other does."""

import math
import types
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from ehamj.compiled import kernel
from ehamj.compiled.identity import identity

SOURCE = '''
@kernel
def inner(value):
    """What it does."""
    return FACTOR * value + ROW["a"]


def outer(value, n=2):
    """What it does."""
    return inner(value) + scale(n) + Pair(value, math.pi).first
'''
"""An entry point that names a kernel, a number, a record, a named tuple, a module and an intrinsic's like."""


def made(source: str = SOURCE, **scope: Any) -> str:
    """The identity of ``outer``."""
    names = {
        "kernel": kernel,
        "math": math,
        "FACTOR": 2.0,
        "ROW": np.zeros(1, [("a", np.float64)]),
        "Pair": NamedTuple("Pair", [("first", float), ("second", float)]),
        "scale": scaled(3.0),
    }
    module = types.ModuleType("example")
    module.__dict__.update(names | scope)
    exec(source, module.__dict__)
    outer: Any = module.__dict__["outer"]
    return identity(outer)


def scaled(factor: float) -> Any:
    """A kernel that closes over a number."""

    @kernel
    def scale(value: float) -> float:
        return factor * value

    return scale


@pytest.mark.parametrize(
    "change",
    [
        lambda source: source.replace("What it does.", "What it does, in other words."),
        lambda source: "# A comment.\n\n\n" + source,
        lambda source: source.replace("def inner(value):", "def inner(value: 'float') -> 'float':  # typed"),
        lambda source: source + "\n\nOTHER = 5\n",
    ],
)
def test_what_does_not_run_is_no_part_of_it(change: Callable[[str], str]) -> None:
    assert change(SOURCE) != SOURCE
    assert made(change(SOURCE)) == made()


@pytest.mark.parametrize(
    "change",
    [
        {"source": SOURCE.replace("value + ROW", "value - ROW")},
        {"source": SOURCE.replace("n=2", "n=3")},
        {"FACTOR": 2.5},
        {"FACTOR": 2},  # a whole number is another type
        {"ROW": np.zeros(1, [("b", np.float64), ("a", np.float64)])},
        {"ROW": np.ones(1, [("a", np.float64)])},
        {"Pair": NamedTuple("Pair", [("second", float), ("first", float)])},
        {"scale": scaled(3.5)},
    ],
)
def test_whatever_it_names_is_part_of_it(change: dict[str, Any]) -> None:
    assert made(**change) != made()


def test_what_cannot_be_told_from_a_changed_one_is_refused() -> None:
    with pytest.raises(TypeError, match="a dict"):
        made(FACTOR={"a": 1.0})

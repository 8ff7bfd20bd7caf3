"""Measured modes beside computed ones, before and after, as tables."""

from collections.abc import Iterator, Mapping
from typing import Any

from ehamj.pages import Table
from ehamj.pages.words import DASH, number, within


def mode_tables(found: Mapping[str, Any]) -> Iterator[Table]:
    """Tables of what a test of modes found, its pairs ``before`` and ``after``; none of any other."""
    before, after = found.get("before"), found.get("after")
    if not isinstance(before, Mapping) or not isinstance(after, Mapping):
        return
    rows = [_row(one, other) for one, other in zip(before["modes"], after["modes"], strict=True)]
    head = (
        "measured [Hz]",
        "model before [Hz]",
        "after [Hz]",
        "damping [%]",
        "after [%]",
        "MAC before",
        "after",
        "which",
    )
    missed = after["not_measured"]
    note = f"Not measured: {', '.join(missed)}." if missed else ""
    yield Table("Modes", head, rows, note, kind="words", numeric=range(1, 7))


def _row(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[str]:
    hertz, spread = after["frequency_hz"], after["frequency_deviation_hz"]
    which = after["name"] or after["why"] or DASH
    return [
        within(hertz, spread) if spread else number(hertz, 4),
        number(before["computed_frequency_hz"], 4),
        number(after["computed_frequency_hz"], 4),
        number(_per_cent(after["damping_ratio"])),
        number(_per_cent(after["computed_damping_ratio"])),
        number(_likeness(before), 2),
        number(_likeness(after), 2),
        which,
    ]


def _per_cent(value: float | None) -> float | None:
    return None if value is None else 100.0 * value


def _likeness(pair: Mapping[str, Any]) -> float | None:
    """MAC of a pair, of close modes the share of the shape that lies in all of them."""
    together: float | None = pair["mac_of_close_modes"]
    return pair["mac"] if together is None else together

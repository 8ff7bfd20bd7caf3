"""How what the bench found is read: tables, each with a line that says what a row is and which way is better."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple, Self

HIGHER, LOWER = "higher is better", "lower is better"
RATE: Final = "simulated seconds per second"
BARE: Final = "bare scalar loop"
BARE_IS: Final = (
    "the same equations in a compiled loop without any engine, one machine at a time: its steps alone; the ceiling is "
    "that loop with the set-up of its model"
)


class Table(NamedTuple):
    """One table of figures."""

    title: str
    words: str
    """What a row is, what others are measured by, and which way is better."""
    heads: Sequence[str]
    """With units; the first is that of the rows' names."""
    rows: Sequence[tuple[str, ...]]

    @classmethod
    def of(
        cls, title: str, words: str, first: str, columns: Mapping[str, Mapping[str, float]], names: Mapping[str, str]
    ) -> Self:
        """Of columns by head, each of which has numbers by key; ``names`` are those of the rows, by key, in order."""
        rows = [
            (name, *(f"{column[key]:.4g}" if key in column else "" for column in columns.values()))
            for key, name in names.items()
        ]
        return cls(title, words, (first, *columns), rows)


def crossed(found: Mapping[str, Mapping[str, float]], key: str) -> dict[str, float]:
    """One number of each, by name."""
    return {name: values[key] for name, values in found.items() if key in values}


def listed(title: str, found: Mapping[str, Any]) -> Table:
    """Numbers by their keys, whose names say what they are and in which unit."""
    rows = [(name, f"{value:.4g}") for name, value in _flat(found)]
    return Table(
        title[:1].upper() + title[1:],
        "A row is a figure by its key, which ends with its unit.",
        ("figure", "value"),
        rows,
    )


def _flat(content: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, float]]:
    """Every number with the keys that lead to it, joined by dots."""
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value

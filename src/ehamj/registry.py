"""Entries of one kind by name: what a schema, a command line or a page lists is derived from such a table."""

from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from ehamj.errors import InputError, did_you_mean

T = TypeVar("T")


class Registry(Mapping[str, T]):
    """Entries by name, in the order in which they were registered.

    ``kind`` is what an entry is called in messages: "study", "norm".
    """

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._entries: dict[str, T] = {}

    def add(self, name: str, entry: T) -> T:
        """Register an entry.

        Raises:
            ValueError: if the name is taken.
        """
        if name in self._entries:
            raise ValueError(f"{self.kind} {name!r} is registered twice")
        self._entries[name] = entry
        return entry

    def register(self, name: str) -> Callable[[T], T]:
        """Decorator that registers what it decorates under a name."""
        return lambda entry: self.add(name, entry)

    def find(self, name: str) -> T:
        """The entry of a name that a user wrote.

        Raises:
            InputError: if there is none; it lists those that there are.
        """
        if name not in self._entries:
            near = did_you_mean(name, self._entries)
            raise InputError(f"{self.kind} {name!r}: {near}must be one of {', '.join(self._entries)}")
        return self._entries[name]

    def __getitem__(self, name: str) -> T:
        return self._entries[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

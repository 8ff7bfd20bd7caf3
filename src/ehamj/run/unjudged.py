"""What of a finished run cannot be judged is said, and all else is kept: nobody simulates again for a figure."""

from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


class Judging:
    """Parts of a summary, each of which may fail by itself."""

    def __init__(self) -> None:
        self.lost: dict[str, str] = {}
        """What failed, by the part."""

    def of(self, part: str, made: Callable[[], T], otherwise: Callable[[], T]) -> T:
        """What is ``made`` for a part of the summary, or, where that fails, what stands there ``otherwise``."""
        try:
            return made()
        except Exception as error:  # whatever it is, it comes after hours of stepping
            self.lost[part] = in_words(error)
            return otherwise()

    @property
    def warnings(self) -> list[str]:
        """What could not be judged, in words."""
        return [f"not judged: {part} ({why})" for part, why in self.lost.items()]


def in_words(error: Exception) -> str:
    """An error in one line."""
    return ": ".join((type(error).__name__, *str(error).splitlines()[:1]))

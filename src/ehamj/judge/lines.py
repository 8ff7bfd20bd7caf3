"""Lines that laws follow: where each was at the end of a run."""

from collections.abc import Sequence

from ehamj.findings import Finding


class FoundLine(Finding):
    """A line as it is stated, within what range it is followed, and where it was at the end [Hz]."""

    stated: float
    low: float
    high: float
    found: float

    @property
    def words(self) -> str:
        """In words."""
        return f"{self.stated:g} Hz at {self.found:.5g} Hz"

    @property
    def at_end(self) -> bool:
        """Whether it stands at an end of a range; to single precision, as it is recorded."""
        near = 1e-6 * self.stated
        return self.low < self.high and not self.low + near < self.found < self.high - near


def beyond(lines: Sequence[FoundLine]) -> list[str]:
    """What must be said of lines that are followed to an end of their range."""
    return [
        f"the line at {line.stated:g} Hz was followed to the end of its range, {line.found:.5g} Hz: it may be further "
        "off, or too weak to be followed; state its frequency better in lines of [control], or a larger drift"
        for line in lines
        if line.at_end
    ]

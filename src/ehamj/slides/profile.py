"""What a profile of a slide is: one kind is one file beside this, and an entry in `ehamj.slides.kinds`."""

from abc import abstractmethod

from ehamj.settings import Settings
from ehamj.signals import Signal


class Profile(Settings):
    """Where a slide stands at each time: coordinate along its rail [m]."""

    kind: str

    @property
    def start(self) -> float | None:
        """Where it stands at first [m], where the profile says so."""
        return None

    @abstractmethod
    def course(self, start: float) -> Signal:
        """Coordinate [m], speed [m/s] and acceleration [m/s²], which is continuous, of a slide that begins at
        ``start`` [m] and is at rest before time 0."""

    @abstractmethod
    def farthest(self, start: float) -> list[tuple[str, float]]:
        """Every coordinate [m] at which it turns or stops, and the key that leads there."""

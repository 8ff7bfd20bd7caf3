"""A slide that stands."""

from typing import Literal

from ehamj.signals import Signal
from ehamj.slides.profile import Profile
from ehamj.slides.scurve import Course


class Rest(Profile):
    """It stands where it starts."""

    kind: Literal["rest"] = "rest"

    def course(self, start: float) -> Signal:
        return Course.of(start, [])

    def farthest(self, start: float) -> list[tuple[str, float]]:
        return []

"""A slide that goes from place to place, each time from rest to rest with limited jerk."""

from itertools import pairwise
from typing import Literal, Self

from pydantic import Field, model_validator

from ehamj.settings import Positive, Settings
from ehamj.signals import Signal
from ehamj.slides.profile import Profile
from ehamj.slides.scurve import Course, seven_pieces


class Move(Settings):
    """One move from where the slide stands."""

    time: float = Field(ge=0, description="when it begins [s]")
    to: float = Field(description="where it ends, coordinate along the rail [m]")
    speed: Positive = Field(0.5, description="limit of the speed [m/s]")
    acceleration: Positive = Field(5.0, description="limit of the acceleration [m/s²]")
    jerk: Positive = Field(100.0, description="limit of the jerk [m/s³]")


class Moves(Profile):
    """Moves one after the other, seven pieces each."""

    kind: Literal["moves"]
    moves: tuple[Move, ...] = Field(description="in the order of time", min_length=1)

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        for k, (one, other) in enumerate(pairwise(self.moves)):
            if other.time <= one.time:
                raise ValueError(
                    f"moves.{k + 1}.time = {other.time:g} s must be later than the move before, {one.time:g} s"
                )
        return self

    def course(self, start: float) -> Signal:
        """Raises ValueError where a move begins before the one before it has ended."""
        at, ended, made = start, 0.0, []
        for k, move in enumerate(self.moves):
            if move.time < ended - 1e-9:
                raise ValueError(
                    f"moves.{k}.time = {move.time:g} s: it must be at least {ended:.6g} s, when the move before ends"
                )
            if move.to != at:
                pieces = seven_pieces(abs(move.to - at), move.speed, move.acceleration, move.jerk)
                made.append((move.time, move.to, pieces))
                ended = move.time + float(pieces[0].sum())
            at = move.to
        return Course.of(start, made)

    def farthest(self, start: float) -> list[tuple[str, float]]:
        return [(f"moves.{k}.to", move.to) for k, move in enumerate(self.moves)]

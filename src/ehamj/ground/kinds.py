"""The kinds of ground there are."""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from ehamj.ground.broadband import BroadbandGround, BurstGround, ShapedGround
from ehamj.ground.floors import FloorGround
from ehamj.ground.motion import Combined, GroundSettings, Motion, Start
from ehamj.ground.records import RecordGround
from ehamj.ground.synthetic import MultisineGround, RestGround, ShockGround, SineGround, SweepGround
from ehamj.settings import one_of

GROUNDS: tuple[type[GroundSettings], ...] = (
    RestGround,
    SineGround,
    MultisineGround,
    SweepGround,
    ShockGround,
    BroadbandGround,
    BurstGround,
    ShapedGround,
    FloorGround,
    RecordGround,
)
"""Every kind of ground; [ground] holds one of them, or a sum."""

if TYPE_CHECKING:
    OneGround = GroundSettings
    Ground = GroundSettings
else:
    OneGround = one_of(GROUNDS)


class SumGround(GroundSettings):
    """Several grounds at once."""

    kind: Literal["sum"]
    parts: tuple[OneGround, ...] = Field(description="grounds that add up", min_length=1)

    def motion(self, start: Start) -> Motion:
        return Combined(tuple(part.motion(replace(start, part=(k,))) for k, part in enumerate(self.parts)))

    def named_mounts(self) -> Iterator[tuple[str, str]]:
        for k, part in enumerate(self.parts):
            yield from ((f"parts.{k}.{key}", mount) for key, mount in part.named_mounts())


if not TYPE_CHECKING:
    Ground = one_of((*GROUNDS, SumGround))

"""Response surfaces: merits over the two parameters that do most to them."""

from collections.abc import Iterator, Sequence

from ehamj.campaign.influence import Influence
from ehamj.campaign.studied import Studied
from ehamj.studies.outcome import Drawing


def surface_drawings(studied: Studied, influences: Sequence[Influence]) -> Iterator[tuple[str, Drawing]]:
    """A map of each merit."""
    yield from ()

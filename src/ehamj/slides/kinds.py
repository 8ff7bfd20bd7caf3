"""The kinds of profile that there are."""

from typing import TYPE_CHECKING

from ehamj.settings import one_of
from ehamj.slides.moves import Moves
from ehamj.slides.profile import Profile
from ehamj.slides.rest import Rest
from ehamj.slides.table import TableProfile

PROFILES: tuple[type[Profile], ...] = (Rest, Moves, TableProfile)
"""Every kind of profile; ``profile`` of a slide holds one of them."""

if TYPE_CHECKING:
    AnyProfile = Profile
else:
    AnyProfile = one_of(PROFILES)

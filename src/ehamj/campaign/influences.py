"""Which measure of influence a plan's designs allow, and that of every merit."""

from ehamj.campaign.influence import Influence, rank_correlations
from ehamj.campaign.studied import Studied


def influences_of(studied: Studied) -> list[Influence]:
    return [one for name in studied.file.wanted if (one := rank_correlations(studied, name))]

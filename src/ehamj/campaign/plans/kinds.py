"""The kinds of plans there are."""

from typing import Final

from ehamj.campaign.plans.draws import LatinHypercube, MonteCarlo, SobolSequence
from ehamj.campaign.plans.grids import Grid, OneAtATime
from ehamj.campaign.plans.indices import Morris, Sobol
from ehamj.campaign.plans.optimise import Optimise
from ehamj.campaign.plans.plan import Plan

PLANS: Final[tuple[type[Plan], ...]] = (
    Grid,
    OneAtATime,
    LatinHypercube,
    SobolSequence,
    MonteCarlo,
    Morris,
    Sobol,
    Optimise,
)
"""Every kind of plan; [plan] of a study file holds one of them."""

"""The kinds of candidate there are: one more is a class in a file beside this one, and an entry here."""

from ehamj.identification.planning.candidate import CandidateSettings
from ehamj.identification.planning.forces import HammerCandidate, ShakerCandidate, StaticCandidate
from ehamj.identification.planning.otherwise import FloorCandidate, LeakDownCandidate
from ehamj.identification.planning.valves import ValveCandidate

CANDIDATES: tuple[type[CandidateSettings], ...] = (
    ValveCandidate,
    HammerCandidate,
    ShakerCandidate,
    FloorCandidate,
    LeakDownCandidate,
    StaticCandidate,
)
"""Every kind; a table [[plan.candidates]] holds one of them."""

"""Every case, and how they are run."""

from collections.abc import Callable, Iterable

from ehamj.verify import conservation, hydraulics, machine
from ehamj.verify.case import Case, Outcome, Subject, run_case

CASES: tuple[Case, ...] = (*hydraulics.CASES, *conservation.CASES, *machine.CASES)
"""All cases in the order in which they are reported."""


def verify(
    progress: Callable[[Outcome], None] | None = None,
    cases: Iterable[Case] = CASES,
    subject: Subject | None = None,
) -> list[Outcome]:
    """Run the cases.

    Args:
        progress: called with each outcome as it comes.
        cases: which.
        subject: what is verified; ehamj itself by default.
    """
    outcomes = []
    for case in cases:
        outcomes.append(run_case(case, subject))
        if progress is not None:
            progress(outcomes[-1])
    return outcomes

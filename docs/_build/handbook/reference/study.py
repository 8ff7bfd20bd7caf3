"""Every key of a study file, on one page for each of its tables."""

from ehamj.campaign.file import StudyFile
from handbook.reference.tables import pages_of

TITLES = {
    "vary": ("Spreads", "How the values of a parameter spread, by the keys that a table has."),
    "plan": ("Plans", "Which designs a study makes."),
    "limits": ("Limits", "What a merit must keep."),
    "correlation": ("Correlations", "Parameters that go together."),
    "tolerances": ("Tolerances", "Machines around the best designs."),
    "confirm": ("Confirmation", "The best designs once more, otherwise."),
    "budget": ("Budget", "How much a study may take."),
}
"""Title and first sentence of each page, by its key."""


def study_pages() -> dict[str, str]:
    """Markdown by path within the site."""
    said = (
        "A study file is TOML: which machine, what is varied, which designs that makes, and what is asked of them. "
        "`ehamj schema study` prints the same as a JSON schema."
    )
    return pages_of(StudyFile, "study", "Keys of a study file", said, TITLES)

"""Every key of an identification file, on one page for each of its tables."""

from ehamj.identification.file import IdentifyFile
from handbook.reference.tables import pages_of

TITLES = {
    "parameters": ("Parameters", "How the values are looked for, each by its key in the scenario."),
    "test": ("Tests that were made", "What was measured, by the kinds of tests that there are."),
    "fit": ("Fit", "How the values are fitted to the tests."),
    "choice": ("Options of the valves", "What the valves may have if the tests justify it."),
    "plan": (
        "Tests that could be made",
        "What `ehamj identify FILE --plan` chooses from, by the kinds of candidates that there are, and what counts.",
    ),
}
"""Title and first sentence of each page, by its key."""


def identify_pages() -> dict[str, str]:
    """Markdown by path within the site."""
    said = (
        "An identification file is TOML: which machine, which of its values are looked for, which tests tell them, and "
        "which could. `ehamj schema identify` prints the same as a JSON schema."
    )
    return pages_of(IdentifyFile, "identify", "Keys of an identification file", said, TITLES)

"""Numbers stay beside their units where lines break."""

import re
from typing import Final, TypeVar

Text = TypeVar("Text", bound=str)

UNITS: Final = (
    r"(?:dB|Hz|kHz|µm/s|mm/s|nm/s|µm|mm|nm|m/s²|m/s|m³/s|m|s|ms|V|mA|kg m²|kg m|kg|N s/m|N/m|N m|N|kN|bar|MPa|GPa|Pa|"
    r"µrad|rad/s|rad|%|l/min)"
)
GLUED: Final = re.compile(rf"(?<=\d) (?={UNITS}(?![\w/]))")
"""A space that stands between a number and its unit."""
GLUE: Final = "\N{NO-BREAK SPACE}"


def glued(text: Text) -> Text:
    """A text, or markup, whose numbers no line break parts from their units."""
    return type(text)(GLUED.sub(GLUE, text))

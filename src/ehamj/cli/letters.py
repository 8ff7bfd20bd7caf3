"""Letters that a terminal does not have, in those that it has."""

import codecs
import sys
import unicodedata
from io import TextIOWrapper
from typing import Final

PLAIN: Final = {
    "µ": "u", "μ": "u", "·": "*", "×": "x", "−": "-", "–": "-", "±": "+/-", "√": "sqrt", "°": " deg", "²": "^2",
    "³": "^3", "≤": "<=", "≥": ">=", "→": "->", "∞": "inf", "─": "-", "━": "-", "│": "|", "ω": "omega", "ζ": "zeta",
    "β": "beta", "τ": "tau", "Δ": "d", "Σ": "sum", "φ": "phi", "∠": " at ", "“": '"', "”": '"', "’": "'",
}  # fmt: skip
"""What is read in place of a letter."""


def spelled(error: UnicodeError) -> tuple[str, int]:
    """What an encoding writes that has no letter for it, as `codecs.register_error` takes it."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_plain, error.object[error.start : error.end])), error.end


def _plain(letter: str) -> str:
    found = PLAIN.get(letter) or unicodedata.normalize("NFKD", letter).encode("ascii", "ignore").decode()
    return found or "?"


def write_any_letter() -> None:
    """Let both streams write every text, whatever their encoding: with C's, a command would end at its first µ."""
    codecs.register_error("ehamj.spelled", spelled)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="ehamj.spelled")

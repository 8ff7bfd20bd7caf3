"""Equations: LaTeX between dollars, as MathML that a browser shows without a script."""

import re
import unicodedata
from html import unescape
from typing import Final

from latex2mathml.converter import convert

_FOUND: Final = re.compile(
    r'<(?P<tag>span|div) class="arithmatex">\\(?P<opens>[(\[])(?P<latex>.*?)\\[)\]]</(?P=tag)>', re.DOTALL
)

_SIGN: Final = re.compile(r"<mi>([^<]+)</mi>")
_CLOSE: Final = re.compile(r"<mo((?: stretchy=\"false\")?)>(&#x0007C;|&#x0002F;)</mo>")
"""Bars and slashes, which stand close to what is beside them."""
_LETTERS: Final = "∞∂∇"
"""Signs that are written as letters are."""


def typeset(html: str) -> str:
    """A page with every equation that Arithmatex marked as MathML; those of a paragraph of their own may scroll.

    Raises:
        ValueError: if an equation cannot be read; it says which.
    """
    return _FOUND.sub(_mathml, html)


def _mathml(found: re.Match[str]) -> str:
    latex, displayed = unescape(found["latex"]).strip(), found["opens"] == "["
    try:
        made = convert(latex, display="block" if displayed else "inline")
    except Exception as error:  # the library has one for each of a dozen faults, and IndexErrors
        raise ValueError(f"the equation {latex!r} cannot be read: {type(error).__name__} {error}") from error
    unknown = re.findall(r"\\\w+", made)
    if unknown or latex.count("{") - latex.count("\\{") != latex.count("}") - latex.count("\\}"):
        told = f"{unknown[0]} is not known" if unknown else "its braces are not closed"
        raise ValueError(f"the equation {latex!r} cannot be read: {told}")
    made = _CLOSE.sub(r'<mo\1 lspace="0" rspace="0">\2</mo>', _SIGN.sub(_operator, made))
    return f'<div class="equation">{made}</div>' if displayed else str(made)


def _operator(found: re.Match[str]) -> str:
    """A sign such as ± or ·, which the library takes for a letter, with the space of an operator."""
    sign = unescape(found[1])
    known = len(sign) == 1 and sign not in _LETTERS and (unicodedata.category(sign) == "Sm" or sign == "·")
    return f"<mo>{found[1]}</mo>" if known else found[0]

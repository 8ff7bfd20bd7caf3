"""What libraries say while they read a file: warnings, logs and errors, as texts of one line."""

import logging
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

LONGEST_LOGGED = 80
"""Characters that are kept of what is logged: damaged files are quoted at length."""


def one_line(said: object) -> str:
    """A text on one line, whatever breaks and blanks are in it."""
    return " ".join(str(said).split())


def warned(caught: Sequence[warnings.WarningMessage]) -> list[str]:
    """The texts of warnings, each once and in order, but for those to programmers of what will change."""
    texts = [one_line(one.message) for one in caught if not issubclass(one.category, DeprecationWarning)]
    return list(dict.fromkeys(texts))


@contextmanager
def logged(name: str) -> Iterator[list[str]]:
    """The warnings and errors that a library logs under ``name``, which are not handed on to Python's root logger."""
    said: list[str] = []
    handler = logging.Handler(logging.WARNING)
    handler.emit = lambda record: said.append(record.getMessage()[:LONGEST_LOGGED])  # type: ignore[method-assign]
    logger = logging.getLogger(name)
    logger.addHandler(handler)
    handed_on, logger.propagate = logger.propagate, False
    try:
        yield said
    finally:
        logger.removeHandler(handler)
        logger.propagate = handed_on

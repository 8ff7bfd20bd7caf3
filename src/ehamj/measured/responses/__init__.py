"""Frequency responses of a test, as analysers write them, with how well each is known."""

from ehamj.measured.responses.reading import read_responses
from ehamj.measured.responses.settings import ResponseChoices

__all__ = ["ResponseChoices", "read_responses"]

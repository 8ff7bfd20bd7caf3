"""Whether a file looks like a table of text, for files whose ending says nothing."""

import re

from ehamj.records.lines import CONTROL, encoding_of
from ehamj.records.table_choices import UNSAID
from ehamj.records.tables.dialects import sample_of, shapes
from ehamj.records.tables.places import COMMENTS

OTHERS = re.compile(
    r"\s*(?:TIMESERIES |WID[12] |XW01|DELTA: |Origin Time|DATASET |EVENT_NAME:|PEER )|.*-12345\.0", re.DOTALL
)
"""Beginnings of seismic formats in text (TSPAIR, GSE, SH, K-NET, PDAS, ESM, PEER), and what SAC's has in its head."""


def looks_like_table(head: bytes) -> bool:
    """Whether the first bytes of a file are text with rows of numbers, or a preamble so long that none came yet."""
    encoding, mark = encoding_of(head)
    text = head[mark:].decode(encoding, errors="ignore")
    if CONTROL.search(text) or OTHERS.match(text):
        return False
    lines = re.split(r"\r\n|\n|\r", text)
    whole = lines[:-1] if len(lines) > 1 and len(head) >= 4096 else lines
    sample = sample_of(whole, COMMENTS)
    return bool(shapes(sample, UNSAID)) or (len(head) >= 4096 and len(lines) > 10)

"""What a page of text shows: its fenced blocks, in order, and whether an output is the one it shows."""

import re
from typing import NamedTuple

FENCE = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
TITLE = re.compile(r'title="([^"]+)"')
NUMBER = re.compile(r"\d+(?:\.\d+)?")


class Block(NamedTuple):
    """A fenced block: its language, the file that it is (by `title=`), its text, and the line where it stands."""

    language: str
    title: str | None
    body: str
    line: int


def blocks(text: str, language: str | None = None) -> list[Block]:
    """The fenced blocks of a text, all or those of one language."""
    found = []
    for match in FENCE.finditer(text):
        named = TITLE.search(match[2])
        line = text.count("\n", 0, match.start()) + 2
        found.append(Block(match[1], named and named[1], match[3], line))
    return [block for block in found if language in (None, block.language)]


def commands(block: Block) -> list[str]:
    """The command lines of a shell block: without comments, lines that end in a backslash joined."""
    joined = block.body.replace("\\\n", " ")
    return [line for line in (re.sub(r"(^|\s)#.*", "", line).strip() for line in joined.splitlines()) if line]


def missing(shown: str, printed: str, share: float = 0.03) -> list[str]:
    """Lines of what is shown that were not printed: words alike, numbers within `share` or one of their last digit.

    3 % is what a figure may move before a reader would take it for another one.
    Blanks, rules of tables and marks after a word do not count, nor do lines of an ellipsis.
    """
    words = _words(printed)
    lines = [line for line in shown.splitlines() if _words(line) not in ([], ["…"])]
    return [line for line in lines if not _stands(_words(line), words, share)]


def _words(text: str) -> list[str]:
    return [word.rstrip(",.;:") for word in text.split() if word.strip("─-")]


def _stands(line: list[str], words: list[str], share: float) -> bool:
    length = len(line)
    return any(
        all(_alike(one, other, share) for one, other in zip(line, words[at : at + length], strict=True))
        for at in range(len(words) - length + 1)
    )


def _alike(shown: str, printed: str, share: float) -> bool:
    if NUMBER.sub("#", shown) != NUMBER.sub("#", printed):
        return False
    for one, other in zip(NUMBER.findall(shown), NUMBER.findall(printed), strict=True):
        last = 10.0 ** -len(one.partition(".")[2])
        if abs(float(one) - float(other)) > max(share * abs(float(one)), 1.001 * last):
            return False
    return True

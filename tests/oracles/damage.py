"""Damage to files, for readers that must refuse what is damaged, or read it right."""

import numpy as np


def damaged(content: bytes, random: np.random.Generator, head: int, texts: bool = False) -> bytes:
    """A file with bytes turned, lost, doubled, set to what makes numbers large, or cut; half of it in its ``head``.

    Args:
        content: of the file.
        random: draws the damage, one to four times.
        head: bytes at the front that tell how the rest is to be read.
        texts: also single characters that turn numbers into others.
    """
    found = bytearray(content)
    for _ in range(int(random.integers(1, 5))):
        reach = len(found) if random.random() < 0.5 else min(len(found), head)
        at, length = int(random.integers(0, max(1, reach))), int(random.integers(1, 9))
        kind = random.integers(0, 6 if texts else 5)
        if kind == 0:
            found[at : at + 1] = bytes([int(random.integers(0, 256))])
        elif kind == 1:
            del found[at : at + length]
        elif kind == 2:
            found[at:at] = found[at : at + 40]
        elif kind == 3:
            found[at : at + length] = bytes([random.choice([0, 0x7F, 0xFF, 0x39])]) * length
        elif kind == 4:
            found = found[: max(1, at)]
        else:
            found[at : at + 1] = random.choice([b"9", b"-", b"e", b" ", b"\n", b"."])
    return bytes(found)

"""What something needs of the computer's memory, beside what is free."""

import psutil


def gib(size: float) -> str:
    """A size [B] in words."""
    return f"{size / 2**30:.3g} GiB"


def check_memory(what: str, size: float, way_out: str) -> None:
    """Raise ValueError where ``size`` bytes are more than the memory that is free: what needs them, and the way out."""
    free = psutil.virtual_memory().available
    if size > free:
        raise ValueError(f"{what} needs about {gib(size)} of memory and {gib(free)} are free; {way_out}")

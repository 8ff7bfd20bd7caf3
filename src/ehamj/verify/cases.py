"""Every case: its file is imported here, in the order in which cases are reported."""

# isort: off
from ehamj.verify import chambers, valve, conservation, machine, statics

__all__ = ["chambers", "conservation", "machine", "statics", "valve"]

"""Every case: the files that hold them, imported in the order in which cases are reported."""

# ruff: noqa: F401
# isort: off
from ehamj.verify import chambers
from ehamj.verify import valve
from ehamj.verify import conservation
from ehamj.verify import machine
from ehamj.verify import statics
from ehamj.verify import small_motion

"""Every case: the files that hold them, imported in the order in which cases are reported."""

# isort: off
from ehamj.verify import chambers
from ehamj.verify import valve
from ehamj.verify import conservation
from ehamj.verify import machine
from ehamj.verify import statics

FAMILIES = (
    chambers,
    valve,
    conservation,
    machine,
    statics,
)

"""The norms there are: what a scenario may name, and by what name."""

from ehamj.criteria.curves import Norm
from ehamj.criteria.din4150 import DIN_4150_3, DIN_4150_3_FLOORS
from ehamj.criteria.iso2631 import ISO_2631_2
from ehamj.criteria.nist import NIST_A
from ehamj.criteria.vc import CLASSIC
from ehamj.registry import Registry

NORMS: Registry[Norm] = Registry("norm")
NORMS.add("vc", CLASSIC)
NORMS.add("nist-a", NIST_A)
NORMS.add("iso-2631-2", ISO_2631_2)
NORMS.add("din-4150-3", DIN_4150_3)
NORMS.add("din-4150-3-floors", DIN_4150_3_FLOORS)

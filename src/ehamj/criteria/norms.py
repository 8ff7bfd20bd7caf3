"""The norms there are: what a scenario may name, and by what name."""

from ehamj.criteria import iso2631, nist, vc
from ehamj.criteria.curves import Norm
from ehamj.registry import Registry

NORMS: Registry[Norm] = Registry("norm")
NORMS.add("vc", vc.CLASSIC)
NORMS.add("nist-a", nist.NORM)
NORMS.add("iso-2631-2", iso2631.NORM)

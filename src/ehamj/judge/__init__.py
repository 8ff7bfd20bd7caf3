"""How well the machine is isolated: attenuation per third-octave, and what norms say of floor, machine and points."""

from ehamj.estimate.counted import settled
from ehamj.judge.isolation import isolation
from ehamj.judge.summary import Summary

__all__ = ["Summary", "isolation", "settled"]

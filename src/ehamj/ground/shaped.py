"""Random floors shaped to a target spectrum."""

from typing import Literal

from pydantic import Field

from ehamj.ground.lines import RandomGround
from ehamj.ground.motion import Motion, Start
from ehamj.ground.targets import Target
from ehamj.settings import Positive


class ShapedGround(RandomGround):
    """A random floor with the spectrum of a target; there is no motion outside of what the target states."""

    kind: Literal["shaped"]
    target: Target = Field(description="spectrum that the floor has")
    scale: Positive = Field(1.0, description="factor on the motion [-]")
    first: Positive | None = Field(None, description="lowest frequency of the motion [Hz]; without: as the target")
    last: Positive | None = Field(None, description="highest frequency of the motion [Hz]; without: as the target")

    def motion(self, start: Start) -> Motion:
        whole = self.target.spectra(self.axes)
        spectra = {axis: spectrum.cut(self.first, self.last) for axis, spectrum in whole.items()}
        low, high = max(s.low for s in spectra.values()), min(s.high for s in spectra.values())
        scaled = {axis: spectrum.scaled(self.scale) for axis, spectrum in spectra.items()}
        note = f"floor shaped to a {self.target.kind} target from {low:.4g} to {high:.4g} Hz"
        note += f": bands above {high:.4g} Hz are undecided"
        return self.random_floor(start, scaled, notes=(note,), usable_to=high)

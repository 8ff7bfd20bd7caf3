"""A law from a file."""

from pathlib import Path
from typing import Literal

from pydantic import Field

from ehamj.control.bank import ControllerBank, load_controller
from ehamj.control.law import Controller
from ehamj.control.sensors import Sensors
from ehamj.control.settings import ControlSettings
from ehamj.plant.plant import Plant
from ehamj.settings import FileName


class Law(ControlSettings):
    """A control law from a file that `ehamj.Controller.save`, `ehamj design` or another tool wrote."""

    kind: Literal["law"]
    file: FileName = Field(
        description="file of the law, relative to the scenario: JSON, ehamj's or for python-control, or MATLAB's .mat",
        min_length=1,
    )

    def controller(self, plant: Plant, sensors: Sensors) -> Controller | ControllerBank:
        """Read the law, or the bank of laws."""
        return load_controller(Path(self.file))

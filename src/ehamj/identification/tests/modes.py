"""Measured modes: frequencies, damping ratios and shapes, of a file or written one by one."""

from pathlib import Path
from typing import Literal, Self

from pydantic import Field, model_validator

from ehamj.errors import InputError
from ehamj.identification.modal.files import ASSUMED, BAND_SAID, NODES_SAID, WITHIN, modes_of_file
from ehamj.identification.modal.residuals import ModalResiduals
from ehamj.identification.residual import Residuals
from ehamj.identification.tests.test import Context, TestSettings
from ehamj.measured.modes import Deviations, MeasuredModes, ModeEntry, listed, measured_modes
from ehamj.measured.nodes import Frame, Nodes
from ehamj.measured.sensors import Place
from ehamj.scenario.model import Scenario
from ehamj.settings import Band, FileName


class ModesTest(TestSettings):
    """Modes of a hammer test or the like, valves held, paired with the machine's by the likeness of their shapes."""

    kind: Literal["modes"]
    file: FileName | None = Field(
        None,
        description="table, TOML or universal file of modes, or universal file of responses of motions to forces, in "
        "which modes are found",
    )
    mode: tuple[ModeEntry, ...] = Field((), description="instead: modes one by one")
    measurement: dict[str, Place] = Field(
        default_factory=dict, description="where the sensors of the shapes stood, by their names there"
    )
    nodes: Nodes = Field(default_factory=dict, description=NODES_SAID)
    frame: Frame = Field(WITHIN, description="how the coordinates of a universal file lie in the machine")
    band: Band | None = Field(None, description=BAND_SAID)
    deviation: Deviations = Field(ASSUMED, description="standard deviations of modes that state none")

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if (self.file is None) == (not self.mode):
            raise ValueError("must have file, or modes one by one (mode)")
        return self

    def residuals(self, context: Context) -> Residuals:
        """See `TestSettings.residuals`."""
        scenario = self.scenario(context)
        try:
            measured = self._measured(scenario)
            return ModalResiduals.of(self.name, self.hold_out, scenario, context.keys, measured)
        except InputError as error:
            raise InputError(f"test {self.name!r}: {error}") from None

    def _measured(self, scenario: Scenario) -> MeasuredModes:
        if self.file is None:
            table = listed(self.mode, {}, "modes one by one")
            return measured_modes(table, self.measurement, self.deviation, scenario.plant, scenario.points)
        stated = self.deviation if "deviation" in self.model_fields_set else None
        return modes_of_file(Path(self.file), scenario, self.measurement, stated, self.frame, self.nodes, self.band)

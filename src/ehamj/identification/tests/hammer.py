"""Blows of a hammer with the valves held: the modes that they show, beside the machine's."""

from typing import Literal

from ehamj.errors import InputError
from ehamj.identification.modal.blows import Blows
from ehamj.identification.modal.residuals import ModalResiduals
from ehamj.identification.residual import Residuals
from ehamj.identification.tests.test import Context, TestSettings
from ehamj.measured.measured import Measured
from ehamj.measured.modes import MeasuredModes


class HammerTest(Blows, TestSettings):
    """Blows of a hammer on the machine, valves held: what its modes are is found, and paired with the model's.

    Shapes and frequencies do not depend on the hammer's own gain, and tell mass and stiffness by their ratio alone:
    hold the mass, which a scale knows.
    """

    kind: Literal["hammer"]

    def residuals(self, context: Context) -> Residuals:
        """See `TestSettings.residuals`."""
        measured, scenario = self.read(context), self.scenario(context)
        try:
            return ModalResiduals.of(self.name, self.hold_out, scenario, context.keys, measured)
        except InputError as error:
            raise InputError(f"test {self.name!r}: {error}") from None

    def read(self, context: Context) -> MeasuredModes:
        """The modes that the blows show.

        Raises:
            InputError: if a record is not as it must be, or shows no mode.
        """
        given, place = context.measured.get(self.name), self.place(context)
        if isinstance(given, MeasuredModes):
            return given
        if given is not None and not isinstance(given, Measured):
            raise InputError(f"test {self.name!r}: no Measured, but something else was given in Python by this name")
        records = [given] if given is not None else self.records(context.scenario.plant.mounts, place, self.name)
        return self.modes(records, self.scenario(context), place, self.name)

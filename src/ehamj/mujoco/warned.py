"""What MuJoCo warned of while a model was stepped, in words."""

from typing import Final

import mujoco

SAID: Final = {
    mujoco.mjtWarning.mjWARN_INERTIA: "the inertia of the machine or of what moves on it is lost beside the rest "
    "(machine.mass, machine.inertia, part, slide, actuators.NAME.plate_mass)",
    mujoco.mjtWarning.mjWARN_CNSTRFULL: "the engine had no room for the feet's constraints (plates)",
}
"""By kind; there are no contacts and no controls of its own to warn of, and what is not finite or runs away
the stepping loop sees itself."""


def warned(data: mujoco.MjData) -> str | None:
    """The first that it warned of, since its data was made or reset; None where it did not."""
    return next((words for kind, words in SAID.items() if data.warning[int(kind)].number), None)

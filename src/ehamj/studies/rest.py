"""What carries a machine at rest."""

import numpy as np
from numpy.typing import NDArray

from ehamj.linear.machine import LinearModel
from ehamj.plant.levers import plane

Array = NDArray[np.float64]


def static_forces(model: LinearModel) -> dict[str, Array]:
    """What mounts carry at rest: ``stroke`` [m], ``oil`` and ``membrane``, forces on the plate, up [N], (mount,)."""
    plant, rest = model.plant, dict(zip(model.states, model.equilibrium.tolist(), strict=True))
    moved = plane(plant.positions) @ [rest[f"displacement {joint}"] for joint in ("z", "rx", "ry")]
    stroke = np.array(
        [rest.get(f"displacement plate {name}", at) for name, at in zip(plant.mounts, moved, strict=True)]
    )
    pressure = np.array([[rest[f"pressure_{k} {mount}"] for k in (1, 2)] for mount in plant.mounts])
    area = np.array([[a.piston_area, a.piston_area * a.area_ratio] for a in plant.actuators])
    stiffness = np.array([actuator.membrane_stiffness for actuator in plant.actuators])
    return {"stroke": stroke, "oil": (pressure * area) @ [1.0, -1.0], "membrane": -stiffness * stroke}

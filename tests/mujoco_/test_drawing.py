"""The drawing: isolators along their actions, on the floor."""

import mujoco
import numpy as np
import pytest

from ehamj.mujoco.model import build_model
from ehamj.scenario.load import parse_scenario


@pytest.mark.parametrize("plates", ["tied", "sliding"])
def test_isolators_lie_along_their_actions_and_stand_on_the_floor(plates: str) -> None:
    places = {"a": (0.9, 0.6, 0.0), "b": (0.9, -0.6, -0.4), "c": (-0.9, 0.6, 0.2), "level": (-1.1, 0.0, 0.4)}
    along = {"a": (0.0, 0.0, 1.0), "b": (0.0, 0.6, 0.8), "c": (0.0, 0.0, 1.0), "level": (1.0, 0.0, 0.0)}
    table = [{"name": name, "position": place, "direction": along[name]} for name, place in places.items()]
    model = build_model(parse_scenario({"mount": table, "plates": plates}).plant, 1e-4, drawn=True)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    floor = data.geom("floor").xpos[2] + model.geom("floor").size[2]
    posts = set()
    for name, place in places.items():
        d = np.array(along[name])
        for what, distance in (("foot", 0.04), ("plate", -0.03), ("pad", -0.18)):
            geom = data.geom(f"{what} {name}")
            np.testing.assert_allclose(geom.xpos, place + distance * d, atol=1e-12)
            np.testing.assert_allclose(geom.xmat.reshape(3, 3)[:, 2], d, atol=1e-12)
        names = {model.geom(k).name for k in range(model.ngeom)}
        lowest = data.geom(f"pad {name}").xpos[2] - 0.12 * abs(d[2]) - 0.17 * np.hypot(*d[:2])
        if f"post {name}" in names:
            posts.add(name)
            stand = data.geom(f"post {name}")
            np.testing.assert_allclose(stand.xmat.reshape(3, 3), np.eye(3), atol=1e-12)
            lowest = stand.xpos[2] - model.geom(f"post {name}").size[1]
        assert lowest == pytest.approx(floor, abs=1e-6)
    assert posts == {"a", "c", "level"}

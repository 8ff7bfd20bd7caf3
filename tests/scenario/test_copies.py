"""Copies of settings with other values: nothing of what the original had computed of itself is theirs."""

from ehamj.scenario.load import load_scenario


def test_a_copy_on_other_mounts_stands_on_them() -> None:
    scenario = load_scenario("vc-c-floor", ["compare=[]"])
    moved = scenario.varied({"mount.0.position": [0.8, 0.6]})
    assert scenario.plant.positions[0][:2] == (0.9, 0.6)  # both have asked where their mounts are
    assert moved.plant.positions[0][:2] == (0.8, 0.6)
    assert moved.as_designed().plant.positions == scenario.plant.positions
    assert moved.as_designed().table["mount"] == scenario.table["mount"]

"""Which directions a verdict names as actuated: by what the layout's valves drive, and not by habit."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ehamj.judge import isolation
from ehamj.judge.actuation import actuation
from ehamj.plant.layout import Layout
from ehamj.result import make_dataset
from ehamj.scenario.load import parse_scenario

CORNERS = ((0.9, 0.6, 0.0), (0.9, -0.6, 0.0), (-0.9, 0.6, 0.0), (-0.9, -0.6, 0.0))
UP, ALONG, ASIDE = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
FOUR = [(at, UP) for at in CORNERS]
LEVEL = [(CORNERS[0], ALONG), (CORNERS[3], ALONG), (CORNERS[1], ASIDE), (CORNERS[2], ASIDE)]
"""Two along x and two along y: with yaw, which either pair drives."""
SLANTED = (np.sin(0.3), 0.0, np.cos(0.3))


def layout(mounts: list[Any], active: tuple[bool, ...] = ()) -> Layout:
    places, directions = zip(*mounts, strict=True)
    return Layout(np.array(places), np.array(directions), active or (True,) * len(mounts))


@pytest.mark.parametrize(
    ("mounts", "expected"),
    [
        (FOUR, {"vertical": "actuated", "horizontal": "actuated by tilting only"}),
        (
            FOUR + LEVEL,
            {"overall": "actuated in all six motions", "vertical": "actuated", "horizontal": "actuated"},
        ),
        (FOUR + LEVEL[:2], {"vertical": "actuated", "horizontal": "x actuated, y actuated by tilting only"}),
        # All lean in one plane: of what they drive none is heave or surge alone.
        ([(at, SLANTED) for at in CORNERS], {
            "vertical": "actuated in part", "horizontal": "x actuated in part, y actuated by tilting only"
        }),
        (LEVEL, {"vertical": "not actuated", "horizontal": "actuated"}),
    ],
    ids=["upright", "six directions", "no sway", "slanted", "level"],
)  # fmt: skip
def test_directions_are_actuated_as_the_valves_act(mounts: list[Any], expected: dict[str, str]) -> None:
    assert actuation(layout(mounts)) == expected


def test_passive_mounts_actuate_nothing() -> None:
    found = actuation(layout(FOUR + LEVEL, (True,) * 4 + (False,) * 4))
    assert found == actuation(layout(FOUR))
    assert set(actuation(layout(FOUR, (False,) * 4)).values()) == {"not actuated"}


RATE, SECONDS = 500.0, 20.0
TIMES = np.arange(int(RATE * SECONDS) + 1) / RATE


def judged(six: bool, command: float) -> Any:
    """A machine of VC-F vertically and VC-D along y, on a floor of VC-A; upright, or in six directions."""
    plant = parse_scenario({}).plant
    if six:
        places, directions = zip(*(FOUR + LEVEL), strict=True)
        names, actuators = tuple(f"m{k}" for k in range(8)), plant.actuators * 2
        plant = replace(plant, mounts=names, positions=places, directions=directions, actuators=actuators,
                        heights=(0.0,) * 8)  # fmt: skip
    sine, n = np.sqrt(2) * np.sin(2 * np.pi * 20.0 * TIMES), len(plant.mounts)
    values = {name: np.zeros((TIMES.size, n, 3)) for name in ("ground_velocity", "foot_velocity")}
    values |= {"cg_velocity": np.zeros((TIMES.size, 3)), "machine_velocity": np.zeros((TIMES.size, 6))}
    values["ground_velocity"][:] = 40e-6 * sine[:, None, None]
    values["cg_velocity"][:, 1], values["cg_velocity"][:, 2] = 5e-6 * sine, 1e-6 * sine
    values["foot_velocity"][:, 2, 1] = 6e-6 * sine
    values["valve_command"] = np.full((TIMES.size, n), command)
    return isolation(make_dataset(TIMES, values, {}, {"mount": plant.mounts}), plant, RATE)[0].criterion


def test_of_six_directions_the_worst_of_all_axes_is_the_verdict() -> None:
    found = judged(six=True, command=0.1)
    assert list(found.verdict) == ["overall", "vertical", "horizontal"]
    assert found.verdict.overall == "floor VC-A, machine VC-D (actuated in all six motions)"
    worst = found.decisive.verdict.worst
    assert (worst.axis, worst.place, worst.mount) == ("y", "feet", "m2")
    lines = found.lines()
    assert lines["overall"].startswith(f"{found.verdict.overall}. Machine worst at foot m2 along y: 6 µm/s")
    assert lines["vertical"].startswith("floor VC-A, machine VC-F (actuated). Machine worst: centre of gravity VC-F (")
    assert lines["by the largest 1 s RMS"].startswith("overall floor VC-A, machine VC-D (actuated in all six")


def test_upright_mounts_have_the_words_of_before_and_no_other_key() -> None:
    found = judged(six=False, command=0.1)
    assert found.verdict.to_dict() == {
        "vertical": "floor VC-A, machine VC-F (actuated)",
        "horizontal": "floor VC-A, machine VC-D (actuated by tilting only)",
    }
    assert "overall" not in found.decisive.to_dict()
    assert found.decisive.verdict is found.decisive.vertical


def test_without_commands_six_directions_are_passive() -> None:
    assert judged(six=True, command=0.0).verdict.overall == "floor VC-A, machine VC-D (passive)"

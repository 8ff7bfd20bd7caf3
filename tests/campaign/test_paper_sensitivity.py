"""The shipped study of the paper's section 4: its one-at-a-time results are contained, and its indices add up."""

from pathlib import Path

import numpy as np
import pytest

from ehamj.campaign.run import Study, run_study
from ehamj.paper.sensitivity import PARAMETERS, SYMBOLS, one_at_a_time

NAMES = {"omega_h": "hydraulic_frequency", "delta_h": "hydraulic_damping"}
"""The paper's figures that merits call otherwise."""
IN_HERTZ = {"omega_h": 2 * np.pi, "break_frequency": 2 * np.pi}
"""Factor of merits that are frequencies [Hz] to those of the paper [rad/s]."""
SAME = ("hydraulic_stiffness", "velocity_gain", "merritt_limit", "velocity_gain_limit", "break_frequency", "bandwidth")


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    folder: Path = tmp_path_factory.mktemp("study") / "paper"
    return run_study("paper-sensitivity", folder, overrides=["plan.groups=32"])


def test_the_papers_own_results_are_among_its_designs(study: Study) -> None:
    """Each parameter halved and doubled, against the paper's scalar formulas."""
    expected, designs = one_at_a_time(), study.designs
    named = designs[designs["stage"] == "named"].iloc[1:]
    rows = dict(zip(study.file.named, (row for _, row in named.iterrows()), strict=True))
    assert len(rows) == 2 * len(PARAMETERS)
    for parameter in PARAMETERS:
        for word, factor in (("halved", 0.5), ("doubled", 2.0)):
            row = rows[f"{SYMBOLS[parameter]} {word}"]
            for figure in (*NAMES, *SAME):
                found = row[f"actuator.isolator.{NAMES.get(figure, figure)}"] * IN_HERTZ.get(figure, 1.0)
                paper = float(expected[figure].sel(parameter=parameter, factor=factor))
                assert found == pytest.approx(paper, rel=1e-6), (parameter, word, figure)


def test_a_product_of_powers_has_the_indices_of_its_closed_form(study: Study) -> None:
    """The velocity gain is K_v K_Q/A_p, each evenly spread in its logarithm from half to double: E[x²]/E[x]² of all
    three is the same for x and 1/x, so that the three matter alike, and nothing else does."""
    influence = study.outcome.numbers["influence"]["actuator.isolator.velocity_gain"]["total index"]
    moved = {key.rpartition(".")[2] for key, value in influence.items() if abs(value) > 1e-9}
    assert moved == {"valve_gain", "flow_gain", "piston_area"}
    table = study.outcome.tables["influence"].to_dataframe()
    own = table[(table["merit"] == "actuator.isolator.velocity_gain") & (table["measure"] == "total index")]
    span = np.log(4.0)
    ratio = (0.5 * (2.0**2 - 0.5**2) / span) / ((2.0 - 0.5) / span) ** 2  # E[x²]/E[x]²
    total = (ratio - 1.0) * ratio**2 / (ratio**3 - 1.0)
    for _, row in own[own["value"] > 1e-9].iterrows():
        assert row["low"] < total < row["high"]

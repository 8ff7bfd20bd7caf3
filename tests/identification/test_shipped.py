"""The identifications that ship: their records are of the rig that is told of, whose values fit them to their noise."""

import numpy as np
from harness import Cli
from oracles.valve_sweep import FILE, RECORDS, SENSOR, TRUE, record, written

from ehamj.identification.file import load_identify
from ehamj.identification.identify import prepared
from ehamj.identification.residual import Failed
from ehamj.scenario_files import shipped_identifications


def test_they_are_listed_by_name_and_title(cli: Cli) -> None:
    listed = {one["name"]: one["title"] for one in cli("identify", "--json").json["identifications"]}
    assert listed == {name: load_identify(name).title for name in shipped_identifications()}


def test_a_record_is_what_the_rig_writes() -> None:
    """Of two the shorter one."""
    name = min(RECORDS, key=lambda one: RECORDS[one][0])
    kept = FILE.with_name(f"valve-sweep-{name}.csv").read_text(encoding="utf-8").splitlines()
    made = written(record(name)).splitlines()
    assert kept[0] == made[0]
    shipped, again = (np.array([row.split(",") for row in lines[1:]], float) for lines in (kept, made))
    assert (np.abs(shipped - again) <= 1e-3 * shipped.std(axis=0)).all()  # noise is ten times as large


def test_the_rig_that_is_told_of_fits_them_to_their_noise() -> None:
    """And the machine that the file believes in does not."""
    parameters, tests = prepared(load_identify("valve-sweep"), {}, 1)
    believed = {one.name: one.start for one in parameters}
    for test in tests:
        sensors = {one.name: SENSOR if one.name.endswith("S FL.gain") else one.start for one in test.unknowns}
        ran = test.compared([{**believed, **TRUE, **sensors}, {**believed, **sensors}])
        for true, wrong in zip(*(one for one in ran if not isinstance(one, Failed)), strict=True):
            share = [float(np.std(one.measured - one.predicted) / np.std(one.measured)) for one in (true, wrong)]
            assert 0.008 < share[0] < 0.0115, true.name
            assert share[1] > 0.05, true.name

"""Laws as other tools write them, against the law that they are; what is no law is told so in one line."""

import json
import struct
import zlib
from pathlib import Path
from typing import Any

import control
import h5py
import numpy as np
import pytest
from oracles.matlab import save_hdf5, save_plain

from ehamj import Controller, InputError, load_controller
from ehamj.plant.mounts import MOUNTS

STROKES = [f"stroke {mount}" for mount in MOUNTS]
RANDOM = np.random.default_rng(1)
MATRICES: dict[str, Any] = {
    "A": np.diag([0.9, 0.5, 0.1]), "B": RANDOM.normal(size=(3, 4)), "C": RANDOM.normal(size=(4, 3)), "D": np.eye(4),
}  # fmt: skip
LAW = Controller(*MATRICES.values(), inputs=tuple(STROKES), period=2e-4, from_rest=True)
GOOD: dict[str, Any] = {**MATRICES, "Ts": 2e-4, "InputName": STROKES}


def saved(folder: Path, **variables: Any) -> Path:
    """A MATLAB file of structs, whose lists are cell arrays of texts."""
    save_plain(folder / "law.mat", variables)
    return folder / "law.mat"


def of_get(**more: Any) -> dict[str, Any]:
    """What MATLAB's ``get(sys)`` has of a system."""
    return {
        **MATRICES, "E": np.zeros((0, 0)), "Scaled": False, "StateName": ["", "", ""], "StateUnit": ["", "", ""],
        "InternalDelay": np.zeros((0, 1)), "InputDelay": np.zeros((4, 1)), "OutputDelay": np.zeros((4, 1)), "Ts": 2e-4,
        "TimeUnit": "seconds", "InputName": STROKES, "InputUnit": ["m", "m", "m", ""], "OutputName": ["", "", "", ""],
        "OutputUnit": ["", "", "", ""], "Name": "mine", "Notes": [], **more,
    }  # fmt: skip


SPELLED: dict[str, dict[str, Any]] = {
    "a struct under any name": {"s": GOOD},
    "law beside others": {"law": GOOD, "other": GOOD, "plant": GOOD},
    "the matrices themselves": GOOD,
    "what get(sys) has": {"s": of_get()},
    "other spellings": {"s": {**{name.lower(): one for name, one in MATRICES.items()}, "dt": 2e-4, "u_names": STROKES}},
    "a struct array": {"law": [GOOD]},
}


@pytest.mark.parametrize("how", SPELLED)
def test_a_system_in_a_matlab_file_is_the_law_that_it_is(tmp_path: Path, how: str) -> None:
    assert load_controller(saved(tmp_path, **SPELLED[how])).to_dict() == LAW.to_dict()


def test_a_law_in_a_file_of_version_7_3_is_the_same(tmp_path: Path) -> None:
    save_hdf5(tmp_path / "law.mat", {"law": GOOD})
    assert load_controller(tmp_path / "law.mat").to_dict() == LAW.to_dict()


def test_commands_are_named_by_their_mounts_in_any_order(tmp_path: Path) -> None:
    moved = [2, 0, 3, 1]
    windup = 0.01 * np.arange(12.0).reshape(3, 4)
    rows = {"C": MATRICES["C"][moved], "D": MATRICES["D"][moved], "anti_windup": windup[:, moved]}
    path = saved(tmp_path, law={**GOOD, **rows, "OutputName": [MOUNTS[k] for k in moved], "OutputUnit": ["V"] * 4})
    found = load_controller(path)
    assert isinstance(found, Controller)
    np.testing.assert_array_equal(found.C, LAW.C)
    np.testing.assert_array_equal(found.D, LAW.D)
    np.testing.assert_array_equal(found.anti_windup, windup)


def test_what_a_law_has_beside_its_matrices_comes_under_its_own_keys(tmp_path: Path) -> None:
    own = {"delay_s": 1e-4, "voltage_limit_v": 5.0, "switch_on_s": 0.5, "fade_s": 0.25, "from_rest": True}
    found = load_controller(saved(tmp_path, law={**GOOD, **own, "bits": np.zeros((0, 0))})).converter
    assert (found.voltage_limit, found.bits, found.switch_on, found.fade, found.from_rest) == (
        5.0,
        None,
        0.5,
        0.25,
        True,
    )
    assert load_controller(saved(tmp_path, law={**GOOD, **own, "bits": 12.0})).converter.bits == 12


def test_arguments_of_control_ss_are_a_law(tmp_path: Path) -> None:
    system = control.ss(*MATRICES.values(), 2e-4, inputs=STROKES, outputs=list(MOUNTS), name="mine")
    table = {name: getattr(system, name).tolist() for name in "ABCD"} | {"dt": system.dt, "name": system.name}
    names = {"inputs": system.input_labels, "outputs": system.output_labels, "states": system.state_labels}
    for outputs in (list(MOUNTS), [f"y[{k}]" for k in range(4)]):  # those that a system without names has
        (tmp_path / "law.json").write_text(json.dumps(table | names | {"outputs": outputs}))
        assert load_controller(tmp_path / "law.json").to_dict() == LAW.to_dict()
    (tmp_path / "law.json").write_text(json.dumps(table | names | {"inputs": [f"u[{k}]" for k in range(4)]}))
    with pytest.raises(InputError, match="inputs is missing"):
        load_controller(tmp_path / "law.json")


@pytest.mark.parametrize("spelling", ["dt", "Ts", "SampleTime", "sample_time", "tsam"])
def test_any_spelling_of_the_period_makes_json_another_tools(tmp_path: Path, spelling: str) -> None:
    table = {name: one.tolist() for name, one in MATRICES.items()} | {spelling: 2e-4, "inputs": STROKES}
    (tmp_path / "law.json").write_text(json.dumps(table))
    assert load_controller(tmp_path / "law.json").to_dict() == LAW.to_dict()


def test_readings_count_from_rest_unless_said_otherwise_or_they_have_none(tmp_path: Path) -> None:
    feet = [f"foot_velocity {mount} z" for mount in MOUNTS]
    for given, expected in (({}, True), ({"from_rest": False}, False), ({"InputName": feet}, False)):
        found = load_controller(saved(tmp_path, law={**GOOD, **given}))
        assert found.converter.from_rest is expected


@pytest.mark.parametrize("windup", [5, [[1.0], [1.0], [1.0]], [1.0, 2.0, 3.0], "much"])
def test_an_anti_windup_that_does_not_fit_moved_outputs_is_told_so(tmp_path: Path, windup: Any) -> None:
    moved = {"outputs": list(MOUNTS[::-1]), "anti_windup": windup}
    table = {name: one.tolist() for name, one in MATRICES.items()} | {"dt": 2e-4, "inputs": STROKES}
    (tmp_path / "law.json").write_text(json.dumps(table | moved))
    for path in (tmp_path / "law.json", saved(tmp_path, law={**GOOD, **moved})):
        with pytest.raises(InputError, match=r"controller\.anti_windup: has not one column for each of 4 outputs"):
            load_controller(path)


def test_files_in_octaves_own_forms_are_told_how_to_save(tmp_path: Path) -> None:
    path = tmp_path / "law.mat"
    for head in (b"# Created by Octave 7.3.0, Sun Nov 29 2026\n# name: s\n", b"Octave-1-L\0"):
        path.write_bytes(head)
        with pytest.raises(InputError, match=r"form of Octave's own.*save\('-v7'"):
            load_controller(path)
    with h5py.File(path, "w") as file:  # as `save -hdf5`
        file.create_group("s").attrs["OCTAVE_NEW_FORMAT"] = np.uint8(1)
    with pytest.raises(InputError, match=r"form of Octave's own.*save\('-v7'"):
        load_controller(path)


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "continuous": ({"s": {**GOOD, "Ts": 0.0}}, "controller.dt = 0.0: must be the period of the samples"),
    "without a period stated": ({"s": {**GOOD, "Ts": -1.0}}, "controller.dt = -1.0"),
    "no period": ({"s": {**MATRICES, "inputs": STROKES}}, "period_s is missing, as dt or Ts"),
    "a logical period": ({"s": {**GOOD, "Ts": True}}, "controller.dt = True: must be the period of the samples"),
    "two periods": ({"s": {**GOOD, "dt": 1e-4}}, "dt and Ts differ, and mean the same"),
    "no names": ({"s": of_get(InputName=["", "", "", ""])}, "inputs is missing, as inputs or InputName"),
    "no channel": ({"s": {**GOOD, "InputName": ["stroke left", *STROKES[1:]]}}, "channel 'stroke left' is unknown"),
    "unknown": ({"s": {**GOOD, "voltage": 3.0}}, "controller.voltage: unknown key; did you mean 'voltage_limit_v'?"),
    "another unit": ({"s": of_get(InputUnit=["mm", "", "", ""])}, "'stroke front-left' is in 'mm'; it must be in m"),
    "another time": ({"s": of_get(TimeUnit="minutes")}, "TimeUnit = 'minutes': must be seconds"),
    "a delay": ({"s": of_get(InputDelay=np.ones((4, 1)))}, "controller.InputDelay: is no part of a law; as delay_s"),
    "a descriptor": ({"s": {**GOOD, "E": 2.0 * np.eye(3)}}, "controller.E: is no part of a law; solve for x first"),
    "complex": ({"s": {**GOOD, "A": 1j * np.eye(3)}}, "A: has complex entries"),
    "a text": ({"s": {**GOOD, "A": "eye(3)"}}, "controller.A: has entries that are no numbers"),
    "sizes": ({"s": {**GOOD, "B": np.ones((2, 4))}}, "controller.B: has shape (2, 4), it must be (3, 4)"),
    "unstable": ({"s": {**GOOD, "A": 2.0 * np.eye(3)}}, "controller.A: unstable by itself"),
    "two": ({"one": GOOD, "two": GOOD}, "one, two could each be the law; call the one that is 'law'"),
    "none": ({"x": np.ones(3)}, "holds x, and no law: a struct of A, B, C, D"),
    "a plant": ({"plant": GOOD}, "holds plant, and no law"),
    "nameless valves": (
        {"s": {**GOOD, "C": np.ones((5, 3)), "D": np.ones((5, 4))}},
        "outputs: are missing",
    ),
    "no such mount": ({"s": {**GOOD, "OutputName": ["a", "a", "b", "c"]}}, "each once"),
    "beyond": ({"s": {**GOOD, "beyond": "{"}}, "controller.beyond: must be JSON"),
    "more beyond": ({"s": {**GOOD, "beyond": '{"A": 1}'}}, "controller.beyond.A: unknown key"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_no_law_is_told_so_in_one_line(tmp_path: Path, what: str) -> None:
    variables, said = REFUSED[what]
    with pytest.raises(InputError) as told:
        load_controller(saved(tmp_path, **variables))
    assert said in str(told.value)
    assert "law.mat" in str(told.value)
    assert "\n" not in str(told.value)


def matlab_object(name: str) -> bytes:
    """A file with an ``ss`` as MATLAB saves it: an element that only its class can read."""

    def element(kind: int, data: bytes) -> bytes:
        return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    words = b"".join(element(1, word.encode()) for word in (name, "MCOS", "ss"))
    flags = element(6, struct.pack("<II", 17, 0))
    inner = element(14, element(6, struct.pack("<II", 13, 0)) + element(5, struct.pack("<ii", 1, 0)) + element(1, b""))
    return b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + element(14, flags + words + inner)


def test_objects_that_only_matlab_reads_are_told_with_the_way_out(tmp_path: Path) -> None:
    (tmp_path / "law.mat").write_bytes(matlab_object("sys"))
    with pytest.raises(
        InputError, match=r"only MATLAB can read sys \(ss\); .* s = struct\('A', sys\.A, .* save\('law\.mat', 's'"
    ):
        load_controller(tmp_path / "law.mat")


def test_a_damaged_or_huge_file_is_refused_in_one_line(tmp_path: Path) -> None:
    path = saved(tmp_path, law=GOOD)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    bomb = zlib.compress(struct.pack("<II", 14, 2**26) + bytes(2**26), 1)
    (tmp_path / "bomb.mat").write_bytes(content[:128] + struct.pack("<II", 15, len(bomb)) + bomb)
    (tmp_path / "none.mat").write_bytes(b"")
    said = {"law": "truncated or damaged", "bomb": "unfold to more than 0.0625 GiB", "none": "no MATLAB file"}
    for name, words in said.items():
        with pytest.raises(InputError, match=rf"^control\.file = '{name}\.mat'.* {words}[^\n]*$"):
            load_controller(tmp_path / f"{name}.mat")
    with pytest.raises(InputError, match=r"control\.file = 'gone\.mat': there is no such file"):
        load_controller(tmp_path / "gone.mat")

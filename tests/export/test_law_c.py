"""The C of a law does what the stepping loop does: compiled, and fed with what the sensors of nonlinear runs read."""

import ctypes
import shutil
import subprocess
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from harness import Cli

import ehamj
from ehamj.arrays import Array
from ehamj.control import ControllerBank, PythonController
from ehamj.errors import DerivedAnew
from ehamj.export.c.vectors import Vectors
from ehamj.export.c.write import write_law
from ehamj.export.law_c import write_c
from ehamj.export.subject import subject_of
from ehamj.mujoco import hydraulics
from ehamj.run.timestep import choose_timestep
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario

STRICT = ("-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-pedantic", "-ffp-contract=off")
needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler on this machine")
SHORT = "duration=0.08"


@dataclass
class Law:
    """A law that was exported and compiled, and the run that it is held against."""

    folder: Path
    found: Vectors
    library: ctypes.CDLL
    memory: Any

    @classmethod
    def of(cls, folder: Path, scenario: Scenario, controller: Any, *flags: str) -> "Law":
        """Export a law and compile it, with every warning an error."""
        with hydraulics():
            step = choose_timestep(scenario, controller)
        _, found = write_law(scenario, controller, step, "a law", folder)
        made = folder / "law.so"
        subprocess.run(
            ["cc", *STRICT, *flags, "-shared", "-fPIC", "-o", made, folder / "ehamj_law.c", "-lm"], check=True
        )
        return cls(folder, found, ctypes.CDLL(str(made)), ctypes.create_string_buffer(2**16))

    def begin(self) -> None:
        self.library.ehamj_law_init(self.memory)

    def rest(self, readings: Array) -> None:
        self.library.ehamj_law_rest(self.memory, np.ascontiguousarray(readings).ctypes.data_as(ctypes.c_void_p))

    def commands(self, readings: Array) -> tuple[Array, Array]:
        """Of each tick before and after range and rounding [V]."""
        given, count = np.ascontiguousarray(readings), self.found.volts.shape[1]
        volts, commands = np.zeros((len(given), count)), np.zeros((len(given), count))
        first = (ctypes.c_double * count).from_buffer(self.memory)  # volts come first
        for k, row in enumerate(given):
            self.library.ehamj_law_step(
                *(ctypes.c_void_p(x) for x in (self._at, row.ctypes.data, commands[k].ctypes.data))
            )
            volts[k] = first
        return volts, commands

    @property
    def _at(self) -> int:
        return ctypes.addressof(self.memory)


REACHED = """
#include "ehamj_law.h"
double hertz(const ehamj_law_t *law, int k) { return law->hertz[k]; }
double gain(const ehamj_law_t *law, int k) { return law->learnt[k].flow_gain; }
"""
"""How far the law has come that follows lines and learns."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Law:
    """All stages at once, moved so much that each has something to do within a tenth of a second: the valves made good,
    learning, lines that are followed, spools fed back, fade."""
    lines = '{ kind = "adaptive", lines = [60.0, 90.0], time = 0.05, pace = 0.2 }'
    changes = [
        "duration=0.1", "ground.level='VC-A'", "control.switch_on=0.005", "control.fade=0.02", "sensors.spool={}",
        "control.linearisation={quiet=0.45, band=0.001}", "control.learning={band=[100.0, 240.0], least=1e-4}",
        f'control.parts=[{{ kind = "feedforward" }}, {{ kind = "modal" }}, {lines}]', "control.spool_feedback=true",
    ]  # fmt: skip
    folder = tmp_path_factory.mktemp("whole")
    with pytest.warns(DerivedAnew):
        scenario = load_scenario("real-valves", changes)
    (folder / "reached.c").write_text(REACHED)
    return Law.of(folder, scenario, scenario.controller(), str(folder / "reached.c"))


def bank(delay: float, staged: bool = False) -> tuple[Scenario, ControllerBank]:
    """A law at 10 kHz that its floor drives beyond the range, and one at 2.5 kHz that waits longer; ``staged``: of
    valves whose edges are open at null, moved little enough to keep to their side."""
    underlap = ["actuators.isolator.overlap=[-0.2,-0.1,-0.2,-0.15]"] if staged else []
    scenario = load_scenario("shock", [SHORT, "ground.begin=0.0", *underlap])
    made_good = {"quiet": 0.6} if staged else None
    fast = scenario.varied({"control": {"kind": "combined", "delay": delay, "linearisation": made_good}}).controller()
    slower = {"kind": "skyhook", "linearisation": made_good}
    slow = scenario.varied({"control": {**slower, "rate": 2500.0, "delay": 4e-4 + delay}}).controller()
    parts = tuple(replace(one, voltage_limit=1.0, bits=8) for one in (fast, slow))
    return scenario, ControllerBank(parts)


@needs_compiler
def test_every_stage_is_the_loops_own(whole: Law) -> None:
    whole.begin()
    volts, commands = whole.commands(whole.found.readings)
    assert not whole.found.volts[:100].any()  # switched off
    assert np.abs(whole.found.volts).max() > 1.0
    np.testing.assert_allclose(volts, whole.found.volts, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(commands, whole.found.commands)
    reached = {}
    for name in ("hertz", "gain"):
        function = getattr(whole.library, name)
        function.restype = ctypes.c_double
        reached[name] = [function(whole.memory, k) for k in range(2)]
    assert all(one not in (60.0, 90.0) for one in reached["hertz"])
    np.testing.assert_allclose(reached["hertz"], (60.0, 90.0), rtol=0.02)
    assert all(one != 1.0 for one in reached["gain"])


@needs_compiler
def test_begun_anew_it_does_the_same_again(whole: Law) -> None:
    whole.begin()
    first = whole.commands(whole.found.readings)[0]
    whole.begin()
    np.testing.assert_array_equal(whole.commands(whole.found.readings)[0], first)


@needs_compiler
@pytest.mark.parametrize(("delay", "staged"), [(0.0, False), (1e-4, False), (1.3e-4, True)])
def test_several_rates_their_delays_and_the_range_are_the_loops_own(delay: float, staged: bool, tmp_path: Path) -> None:
    law = Law.of(tmp_path, *bank(delay, staged))
    law.begin()
    volts, commands = law.commands(law.found.readings)
    beyond = np.abs(law.found.volts) > 1.0
    assert 0.05 < beyond.any(axis=1).mean() < 0.95  # it is limited, and comes back
    np.testing.assert_allclose(volts, law.found.volts, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(commands, law.found.commands)


@needs_compiler
def test_readings_may_count_from_rest_in_the_c(tmp_path: Path) -> None:
    """A machine whose strokes stand somewhere at rest: what is handed over as rest is taken from them, and no more."""
    law = Law.of(tmp_path, *bank(1e-4))
    header = (tmp_path / "ehamj_law.h").read_text()
    lines = [
        line for line in header.splitlines() if line.startswith("    EHAMJ_LAW_") and " = " in line and "[" in line
    ]
    rests = np.array([", from rest" in line for line in lines])[: law.found.readings.shape[1]]
    assert 0 < rests.sum() < rests.size
    offset = np.where(rests, 0.001, 0.5)
    law.begin()
    law.rest(offset)
    volts, _ = law.commands(law.found.readings + np.where(rests, offset, 0.0))
    # Readings that are moved and moved back are rounded at 1e-16; laws amplify that to some 1e-10 V at most.
    np.testing.assert_allclose(volts, law.found.volts, rtol=0, atol=1e-9)


@needs_compiler
def test_what_is_written_judges_itself(cli: Cli) -> None:
    """make and ./replay as the folder says; a command that is off by 1 nV is found."""
    said = cli("export", "recorded", "--set", SHORT, "--c", "law", "--json")
    assert {Path(name).name for name in said.json["files"]} >= {"ehamj_law.c", "vectors.csv", "README.txt"}
    subprocess.run(["make", "-s", "-C", "law", "CC=cc"], check=True)

    def replayed() -> subprocess.CompletedProcess[str]:
        return subprocess.run(["./replay"], cwd="law", capture_output=True, text=True, check=False)

    right = replayed()
    assert right.returncode == 0, right.stdout
    assert "steps 800\n" in right.stdout
    assert "worst step" in right.stdout
    vectors = Path("law/vectors.csv")
    lines = vectors.read_text().splitlines()
    *most, last = lines[-1].split(",")
    vectors.write_text("\n".join([*lines[:-1], ",".join([*most, repr(float(last) + 1e-9)])]) + "\n")
    assert replayed().returncode == 1
    vectors.write_text("no number\n")
    assert replayed().returncode == 2


CALLS = """
#include "ehamj_law.h"
ehamj_law_t EHAMJ_LAW_PREFIX;
void EHAMJ_LAW_NAME(EHAMJ_LAW_PREFIX, begins)(void) { ehamj_law_init(&EHAMJ_LAW_PREFIX); }
"""
BOTH = "void front_begins(void); void rear_begins(void); int main(void) { front_begins(); rear_begins(); return 0; }"


@needs_compiler
def test_two_laws_run_in_one_program(whole: Law, tmp_path: Path) -> None:
    """Each has a prefix; without, the linker finds everything twice."""
    (tmp_path / "calls.c").write_text(CALLS)
    (tmp_path / "main.c").write_text(BOTH)
    objects = []
    for prefix in ("front", "rear"):
        for source in (whole.folder / "ehamj_law.c", tmp_path / "calls.c"):
            objects.append(tmp_path / f"{prefix}-{source.stem}.o")
            flags = (*STRICT, f"-DEHAMJ_LAW_PREFIX={prefix}", f"-I{whole.folder}", "-c")
            subprocess.run(["cc", *flags, "-o", objects[-1], source], check=True)
    program = tmp_path / "both"
    subprocess.run(["cc", "-o", program, tmp_path / "main.c", *objects, "-lm"], check=True)
    subprocess.run([program], check=True)
    said = subprocess.run(["nm", program], capture_output=True, text=True, check=True).stdout
    assert all(f" {prefix}_ehamj_law_step\n" in said for prefix in ("front", "rear"))


@needs_compiler
def test_a_file_with_the_headers_of_two_laws_is_refused(whole: Law, tmp_path: Path) -> None:
    """Its guard would drop the second in silence; the same one twice is allowed."""
    own = (whole.folder / "ehamj_law.h").read_text()
    (mark,) = {line.split()[-1] for line in own.splitlines() if line.startswith("#define EHAMJ_LAW_TOLD_BY")}
    (tmp_path / "other.h").write_text(own.replace(mark, "0x1"))

    def compiled(second: str) -> subprocess.CompletedProcess[str]:
        (tmp_path / "one.c").write_text(f'#include "ehamj_law.h"\n#include "{second}"\n')
        command = [
            "cc",
            "-std=c99",
            f"-I{whole.folder}",
            f"-I{tmp_path}",
            "-c",
            "-o",
            tmp_path / "one.o",
            tmp_path / "one.c",
        ]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    assert compiled("ehamj_law.h").returncode == 0
    refused = compiled("other.h")
    assert refused.returncode != 0
    assert "the headers of two laws in one file" in refused.stderr


@needs_compiler
def test_in_single_precision_it_compiles_and_is_near(tmp_path: Path) -> None:
    scenario = load_scenario("recorded", ["duration=0.5"])
    law = Law.of(tmp_path, scenario, scenario.controller(), "-DEHAMJ_LAW_FLOAT")
    law.begin()
    given = law.found.readings.astype(np.float32)
    commands = np.zeros(4, np.float32)
    off = []
    for row, volts in zip(given, law.found.volts, strict=True):
        law.library.ehamj_law_step(law.memory, ctypes.c_void_p(row.ctypes.data), ctypes.c_void_p(commands.ctypes.data))
        off.append(np.abs(np.frombuffer(law.memory, np.float32, 4) - volts).max())
    assert 0.0 < max(off) < 2e-5 * np.abs(law.found.volts).max()  # summed as in double: 5e-5


def test_what_has_no_law_is_refused(cli: Cli, tmp_path: Path) -> None:
    assert "has no law, control.kind = 'open-loop'" in cli("export", "benchmark", "--c", "law").message
    assert not Path("law").exists()
    scenario = load_scenario("recorded", [SHORT])
    law = PythonController(lambda *_: np.zeros(4), ("cg_velocity z",))
    with pytest.raises(ehamj.InputError, match="is a Python function"):
        write_law(scenario, law, 1e-4, "a law", tmp_path)
    deaf = ehamj.Controller([[0.9]], np.zeros((1, 0)), np.zeros((4, 1)), np.zeros((4, 0)), ())
    with pytest.raises(ehamj.InputError, match="reads no channel"):
        write_law(scenario, deaf, 1e-4, "a law", tmp_path)


def test_delays_that_leave_different_parts_of_a_tick_are_refused(tmp_path: Path) -> None:
    scenario, laws = bank(1e-4)
    parts = (laws.parts[0], replace(laws.parts[1], delay=5.3e-4))
    with pytest.raises(ehamj.InputError, match=r"end at different times after a tick, .* choose delays"):
        write_law(scenario, ControllerBank(parts), 1e-4, "a law", tmp_path)
    assert not list(tmp_path.iterdir())


def test_vectors_that_end_before_the_fade_say_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ehamj.export.c.vectors.MOST", 50)
    said = write_c(subject_of("recorded", [SHORT, "control.fade=0.01"]), tmp_path)
    assert any("the vectors end at 0.005 s, before the commands have faded in" in note for note in said.notes)
    assert len((tmp_path / "vectors.csv").read_text().splitlines()) == 1 + 50

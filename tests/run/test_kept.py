"""What is kept of a run whose rows cannot all be made or written: a disk that fills meanwhile, memory that ends."""

import subprocess
import sys
from pathlib import Path

import pytest

from ehamj.result import load_result

DISK = 48
"""Size of the file system that fills [MiB]: one of the test's own, which a user without privileges may mount."""

SHORT = """
import os, resource, shutil
from pathlib import Path

import h5netcdf

from ehamj import columns, growing
from ehamj.errors import InputError
from ehamj.mujoco import hydraulics
from ehamj.run import observe
from ehamj.run.failures import Incomplete
from ehamj.run.simulate import driven_alone, ready, seen, simulate
from ehamj.scenario.load import parse_scenario

columns.ROWS = 8192
SCENARIO = parse_scenario({"duration": 4.0, "record_rate": 10000.0, "engine": "small-motion"})
"""

MEMORY = f"""{SHORT}
with hydraulics():
    prepared = ready(SCENARIO).prepared
    driven = driven_alone(prepared)
whole = observe.observe(prepared, driven.rows)
taken = 1024 * int(next(line for line in open("/proc/self/status") if line.startswith("VmSize")).split()[1])
resource.setrlimit(resource.RLIMIT_AS, (taken + int(0.8 * whole.nbytes), resource.RLIM_INFINITY))
run = seen(prepared, driven)
print(run.kept is not None, run.failed, all(run.dataset[name].equals(whole[name]) for name in whole))
"""

FULL = f"""{SHORT}
columns.ROWS, growing.IN_MEMORY, made, full = 1000, 0, observe.observe, 0

def filling(prepared, rows, struck=(), first=0, wanted=None):
    if first >= full:  # others take what is free, to the last byte
        with Path("others").open("ab") as file:
            os.posix_fallocate(file.fileno(), 0, shutil.disk_usage(".").free)
    return made(prepared, rows, struck, first, wanted)

observe.observe = filling
scenario = SCENARIO.varied({{"duration": 0.4}})
try:
    simulate(scenario, within=Path.cwd())
except InputError as error:
    print(error)
Path("others").unlink()
full = 1500
try:
    simulate(scenario, within=Path.cwd())
except Incomplete as broken:
    Path("run").mkdir()
    broken.result.write(Path("run"))
    print(broken)
shutil.copytree("run", "../kept")
"""


def test_a_disk_that_fills_keeps_what_was_written_and_says_so(tmp_path: Path) -> None:
    """One that is full before anything could be written refuses."""
    (tmp_path / "disk").mkdir()
    (tmp_path / "code.py").write_text(FULL)
    own = f"mount -t tmpfs -o size={DISK}m none disk && cd disk && exec {sys.executable} ../code.py"
    try:
        run = subprocess.run(
            ["unshare", "-Urm", "sh", "-c", own], cwd=tmp_path, capture_output=True, text=True, check=False
        )
    except FileNotFoundError:
        pytest.skip("no file system of one's own here")
    if "unshare: " in run.stderr or "mount: " in run.stderr:
        pytest.skip("no file system of one's own here")
    assert not run.returncode, run.stderr
    refused, broken = run.stdout.splitlines()
    assert "No space left on device; " in refused
    assert "nothing of it is kept" in refused
    assert broken.startswith("simulation broken off: rows beyond 0.1999 s could not be kept: ")
    assert "/disk': No space left on device. Kept until 0.1999 s, marked incomplete. Make room there" in broken
    kept = load_result(tmp_path / "kept")
    assert not kept.complete
    assert kept.summary.failure == broken
    assert kept.dataset.sizes["time"] == 2000


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the system does not say what a process has")
def test_channels_that_do_not_fit_in_memory_are_made_a_part_at_a_time() -> None:
    """To the bit as in memory, where there was room for a part of them only."""
    found = subprocess.run([sys.executable, "-c", MEMORY], capture_output=True, text=True, check=False)
    assert found.stdout.split() == ["True", "None", "True"], found.stderr

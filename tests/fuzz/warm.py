"""What a worker does once, so that no case pays for it: imports, compiling, validators."""

import os
import shutil
import sys
from pathlib import Path
from tempfile import mkdtemp

SMALL = ("--set", "duration=0.01", "--set", "compare=[]", "--no-replay", "--no-report")


def warm(kept: Path) -> None:
    """Run what imports and compiles."""
    from fuzz.worker import called, into_files

    folder, stood = Path(mkdtemp(prefix="fuzz-warm-")), Path.cwd()
    os.chdir(folder)
    with into_files(folder):
        for k, name in enumerate(("benchmark", "real-valves")):
            called(("run", name, *SMALL, "--out", f"a{k}"))
            called(("run", name, *SMALL, "--engine", "small-motion", "--out", f"b{k}"))
        called(("report", "a0"))
        called(("modes", "benchmark", "--json"))
        called(("statics", "benchmark", "--json"))
    os.chdir(stood)
    shutil.rmtree(folder)
    sys.stderr.flush()

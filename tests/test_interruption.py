"""Where the user interrupts."""

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path

import pytest

from ehamj.interruption import EXIT_CODE, Interrupted, check, pool_of
from ehamj.run.workers import worked_through

LONG = ["run", "recorded", "--set", "duration=20", "--set", "timestep=1e-6", "--out", "out"]
STEPPING = """
import ehamj.run.drive as drive
check = drive.check
def told():
    drive.check = check
    print("stepping", flush=True)
drive.check = told
from ehamj.cli import main
main()
"""
STUCK = """
import time
from ehamj.interruption import watched
def give_up():
    print("given up", flush=True)
with watched(give_up):
    while True:
        try:
            print("begun", flush=True)
            time.sleep(60)
        except KeyboardInterrupt:
            pass  # as code that does not hear of it
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_command_that_is_interrupted_says_so_and_leaves_nothing(number: signal.Signals, tmp_path: Path) -> None:
    """While it steps, which would take many minutes."""
    command = [sys.executable, "-c", STEPPING, *LONG]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "stepping\n"
    process.send_signal(number)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == EXIT_CODE
    assert said.strip().endswith("ehamj: interrupted; what was not finished is not kept")
    assert said.count("interrupted") == 1
    assert "Traceback" not in said
    assert not list(tmp_path.iterdir())


def test_a_process_that_does_not_hear_is_ended_from_outside() -> None:
    process = subprocess.Popen([sys.executable, "-c", STUCK], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "begun\n"
    os.kill(process.pid, signal.SIGINT)
    assert process.communicate(timeout=60)[0].endswith("given up\n")
    assert process.returncode == EXIT_CODE


def test_threads_of_a_pool_whose_block_fails_stop_where_they_check() -> None:
    begun, ended = threading.Event(), []

    def endless() -> None:
        begun.set()
        try:
            while True:
                check()
                time.sleep(0.001)
        except Interrupted:
            ended.append(True)
            raise

    def interrupted() -> None:
        with pool_of(2) as pool:
            pool.submit(endless)
            begun.wait()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert ended == [True]
    check()  # nobody is asked any more


def test_a_pool_that_fails_stops_no_other() -> None:
    """Two callers of one process, on threads of their own."""
    failed = threading.Event()

    def other(_: int, word: str) -> str:
        failed.wait()
        check()
        return word

    def fail() -> None:
        with suppress(ValueError), pool_of(1) as pool:
            pool.submit(failed.set)
            raise ValueError

    thread = threading.Thread(target=fail)
    thread.start()
    assert worked_through("abcd", other, 2) == list("abcd")
    thread.join()


def test_a_pool_within_another_stops_with_it() -> None:
    begun = threading.Event()

    def endless(_: int, word: str) -> None:
        begun.set()
        while True:
            check()
            time.sleep(0.001)

    def outer() -> None:
        with pool_of(1) as pool:
            inner.append(pool.submit(worked_through, "ab", endless, 1))
            begun.wait()
            raise KeyboardInterrupt

    inner: list[Future[list[None]]] = []
    with pytest.raises(KeyboardInterrupt):
        outer()
    assert isinstance(inner[0].exception(), Interrupted)

"""The scheduler that a user names."""

import re
from typing import Any

from ehamj.campaign.cluster import Dask, is_dask
from ehamj.campaign.processes import Processes
from ehamj.campaign.schedulers import Scheduler, Threads
from ehamj.errors import InputError
from ehamj.run.workers import processors


def scheduler_of(given: Any) -> Scheduler:
    """What a user names: nothing (threads), "threads", "threads:4", "processes", "processes:4", the address of a Dask
    scheduler, such as "tcp://10.0.0.1:8786", a Dask client or cluster, or a `Scheduler`.

    Raises:
        InputError: if it is none of these.
    """
    if isinstance(given, Scheduler):
        return given
    if given is None:
        return Threads()
    if isinstance(given, str):
        own = re.fullmatch(r"(threads|processes)(?::(\d{1,4}))?", given.strip())
        if own and (own[2] is None or int(own[2]) > 0):
            count = processors() if own[2] is None else int(own[2])
            return Threads(count) if own[1] == "threads" else Processes(count)
        if not re.fullmatch(r"[\w+-]+://\S+", given.strip()):
            raise InputError(
                f"scheduler {given!r}: must be threads, threads:N, processes, processes:N, or the address of a Dask "
                "scheduler, such as tcp://10.0.0.1:8786"
            )
        return Dask(given.strip())
    if not is_dask(given):
        raise InputError(
            f"scheduler: must be a name, an address, or a Dask client or cluster, not {type(given).__name__}"
        )
    return Dask(given)

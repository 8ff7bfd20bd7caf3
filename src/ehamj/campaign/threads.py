"""Linear algebra on one thread. How many it takes decides in which order it sums, and so the last digits of a law that
is found with it: they must not depend on how many processors a computer has. Blocks of designs use the others.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any


def _limit() -> Any:
    import scipy.linalg  # noqa: F401
    import slycot  # noqa: F401  # each brings its own library, which can be told once it is there
    from threadpoolctl import threadpool_limits

    return threadpool_limits(1, user_api="blas")


@contextmanager
def one_thread() -> Iterator[None]:
    """While the block lasts, linear algebra of this process takes one thread."""
    with _limit():
        yield


@cache
def stay_on_one_thread() -> None:
    """From now on it does: of a worker, which does nothing else."""
    _limit()

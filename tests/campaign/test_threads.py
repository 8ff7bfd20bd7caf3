"""Linear algebra of a study takes one thread, and afterwards as many as before."""

from threadpoolctl import threadpool_info, threadpool_limits

from ehamj.campaign.threads import one_thread


def counts() -> set[int]:
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


def test_linear_algebra_takes_one_thread_meanwhile() -> None:
    with one_thread():
        pass  # all libraries are there from now on
    with threadpool_limits(2, user_api="blas"):
        before = counts()
        with one_thread():
            assert counts() == {1}
        assert counts() == before

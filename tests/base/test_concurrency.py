"""One thread for linear algebra, until the outermost of those that asked for it leaves."""

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from mbsd3d.extend import one_thread


def threads():
    """Threads of every library of linear algebra in this process."""
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def two_threads():
    with threadpool_limits(2, user_api="blas"):
        if threads() != {2}:
            pytest.skip("the libraries here know one thread only")
        yield


def test_the_limit_holds_until_the_outermost_leaves():
    with one_thread():
        with one_thread():
            assert threads() == {1}
        assert threads() == {1}
    assert threads() == {2}


def test_an_error_takes_the_limit_back():
    with pytest.raises(ZeroDivisionError), one_thread():
        raise ZeroDivisionError
    assert threads() == {2}

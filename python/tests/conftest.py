"""A small room, which all tests light, so that they share kernels."""
import numpy as np
import pytest

import hbil.demo

WIDTH, HEIGHT = 48, 32


@pytest.fixture(scope="session")
def room():
    """depth, normal, albedo, direct, camera."""
    return hbil.demo.room(WIDTH, HEIGHT)


@pytest.fixture(scope="session")
def lit(room):
    return hbil.process(*room)


def same(a, b):
    """Bit by bit."""
    assert a.keys() == b.keys()
    for name in a:
        assert a[name].dtype == b[name].dtype
        np.testing.assert_array_equal(a[name], b[name], err_msg=name)

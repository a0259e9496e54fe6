"""pyopencl's arrays and queues, without copies."""
import numpy as np
import pytest

import hbil

from conftest import HEIGHT, WIDTH, same

cl = pytest.importorskip("pyopencl")
cl_array = pytest.importorskip("pyopencl.array")


@pytest.fixture(scope="module", params=["in order", "out of order"])
def queue(request):
    device = next(device for platform in cl.get_platforms()
                  for device in platform.get_devices())
    properties = (cl.command_queue_properties.OUT_OF_ORDER_EXEC_MODE_ENABLE
                  if request.param == "out of order" else 0)
    return cl.CommandQueue(cl.Context([device]), properties=properties)


def on_device(queue, room):
    return [cl_array.to_device(queue, a) for a in room[:4]] + [room[4]]


@pytest.fixture(scope="module")
def wanted(room):
    # arrays on the device aren't looked at
    return hbil.process(*room, gather_emission=True, far_field="frame",
                        sky_share=0)


def test_arrays_stay_on_the_device(queue, room, wanted):
    given = on_device(queue, room)
    found = hbil.process(*given)
    for name, array in found.items():
        assert isinstance(array, cl_array.Array), name
        assert array.queue == queue
    same({name: array.get() for name, array in found.items()}, wanted)


def test_numpy_arrays_with_a_queue(queue, room, wanted):
    found = hbil.process(*room, queue=queue, gather_emission=True,
                         far_field="frame", sky_share=0)
    same({name: array.get() for name, array in found.items()}, wanted)


def test_results_in_given_arrays(queue, room, wanted):
    ao = cl_array.zeros(queue, (HEIGHT, WIDTH), np.float32)
    host = np.empty((HEIGHT, WIDTH, 3), np.float32)
    found = hbil.process(*on_device(queue, room),
                         out={"ao": ao, "beauty": host})
    assert found["ao"] is ao and found["beauty"] is host
    np.testing.assert_array_equal(ao.get(), wanted["ao"])
    np.testing.assert_array_equal(host, wanted["beauty"])


def test_planes_and_parts_of_arrays(queue, room, wanted):
    depth, normal, albedo, direct, camera = room
    wide = np.zeros((HEIGHT + 3, WIDTH + 5), np.float32)
    wide[2:HEIGHT + 2, 3:WIDTH + 3] = depth
    planes = cl_array.to_device(queue, np.ascontiguousarray(
        np.moveaxis(normal, -1, 0))).transpose((1, 2, 0))
    four = np.zeros((HEIGHT, WIDTH, 4), np.float32)
    four[..., :3] = albedo
    found = hbil.process(
        cl_array.to_device(queue, wide)[2:HEIGHT + 2, 3:WIDTH + 3], planes,
        cl_array.to_device(queue, four)[:, :, :3],
        cl_array.to_device(queue, direct), camera)
    same({name: array.get() for name, array in found.items()}, wanted)


def test_a_sequence_on_the_device(queue, room):
    size = {"voxel_size": 0.5, "voxels": 16}
    mine = hbil.Sequence(cache=size, far_field="frame", gather_emission=True)
    its = hbil.Sequence(cache=size, queue=queue, views=[])
    given = on_device(queue, room)
    for _ in range(3):
        found = its.process(*given)
        same({name: array.get() for name, array in found.items()},
             mine.process(*room))


def test_messages_name_the_argument(queue, room):
    depth, normal, albedo, direct, camera = on_device(queue, room)
    with pytest.raises(TypeError, match="^depth: dtype float64 on the device"):
        hbil.process(depth.astype(np.float64), normal, albedo, direct, camera)
    with pytest.raises(ValueError, match="^normal: strides"):
        hbil.process(depth, normal.transpose((1, 0, 2))[:, :, :3].reshape(
            HEIGHT, WIDTH, 3, order="F"), albedo, direct, camera)

"""Frames in order, with and without a radiance cache."""
import pickle
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import hbil
import hbil.demo

from conftest import HEIGHT, WIDTH, same

SMALL = {"voxel_size": 0.5, "centre": (0, 0, 2), "voxels": 16}


def test_without_a_cache_the_first_frame_is_that_of_process(room, lit):
    with hbil.Sequence(cache=False) as sequence:
        same(sequence.process(*room), lit)
        # one bounce more
        more = sequence.process(*room)["indirect"]
        assert lit["indirect"].mean() < more.mean() < 1.1 * lit["indirect"].mean()
        sequence.reset()
        once = sequence.process(*room)["indirect"]
    assert once.mean() < lit["indirect"].mean()


def test_frames_may_be_static(room):
    wanted, found = (hbil.Sequence(cache=False, slice_frames=1)
                     for _ in range(2))
    for static in False, True, True:
        same(found.process(*room, static=static), wanted.process(*room))


def test_the_cache_lights_what_the_frame_does_not_show(room):
    depth, normal, albedo, direct, camera = room
    left = slice(0, WIDTH // 2)
    half = dict(camera)
    crop = [a[:, left] for a in (depth, normal, albedo, direct)]
    alone = hbil.Sequence(cache=False).process(*crop, half)
    view = hbil.View(depth, normal, albedo, direct, camera)
    with_view = hbil.Sequence(views=[view]).process(*crop, half)
    assert (with_view["ao"] == alone["ao"]).all()
    assert (with_view["far_irradiance"] != alone["far_irradiance"]).any()
    # the green wall is in the view alone
    green = with_view["indirect"][..., 1] / with_view["indirect"][..., 0]
    before = alone["indirect"][..., 1] / alone["indirect"][..., 0]
    assert np.median(green) > np.median(before)


def test_what_is_told_is_forgotten(room):
    depth, normal, albedo, direct, camera = room
    sequence = hbil.Sequence(views=[hbil.View(*room)])
    dark = np.zeros_like(direct)
    before = sequence.process(*room)["far_irradiance"].mean()
    sequence.forget_in_cache(light=1, low=(-1e3, -1e3, -1e3),
                             high=(1e3, 1e3, 1e3))
    after = sequence.process(depth, normal, albedo, dark, camera)
    # .0015; .015 if the cache is not told
    assert after["far_irradiance"].mean() < 0.004 * before
    with pytest.raises(hbil.Error, match="light: 2"):
        sequence.forget_in_cache(light=2)
    with pytest.raises(TypeError, match="^surfaces: 'a'; a number is needed"):
        sequence.forget_in_cache(surfaces="a")


def test_the_size_of_the_cache_is_that_of_the_room(room):
    with hbil.Sequence() as sequence:
        sequence.process(*room)
        saved = sequence.save_cache()
    width = saved["voxels"] * saved["voxel_size"] * 2 ** (saved["levels"] - 1)
    # 5 units to the back wall, from the camera
    assert 10 < width < 10 * 64 / 60 + 0.01
    assert saved["centre"] == (0, 0, 0)
    behind = np.eye(4)
    behind[2, 3] = 15  # another room, which reaches to 20 units
    view = hbil.View(*room[:4], {**room[4], "view_to_world": behind})
    with hbil.Sequence(views=[view]) as sequence:
        sequence.process(*room)
        assert 3.9 < sequence.save_cache()["voxel_size"] / saved["voxel_size"] < 4.1


def test_what_is_saved_is_what_is_loaded(room, tmp_path):
    depth, normal, albedo, direct, camera = room
    view = hbil.View(depth, normal, albedo, direct, camera)
    first = hbil.Sequence(cache=SMALL, views=[view], learn=False)
    wanted = first.process(*room)
    saved = first.save_cache()
    assert saved["voxels"] == 16 and len(saved["bytes"]) > 1000
    with (tmp_path / "cache.npz").open("w+b") as file:
        np.savez(file, **saved)
        file.seek(0)
        with np.load(file) as stored:
            from_file = hbil.Sequence(cache=stored, learn=False)
    same(from_file.process(*room), wanted)
    for cache in saved, pickle.loads(pickle.dumps(saved)):
        same(hbil.Sequence(cache=cache, learn=False).process(*room), wanted)
    with pytest.raises(hbil.Error):
        hbil.Sequence(cache={**saved, "voxel_size": 0.4}).process(*room)


def test_views_before_and_after_the_first_frame(room):
    view = hbil.View(*room)
    before = hbil.Sequence(cache=SMALL, learn=False)
    before.add_views([view])
    wanted = before.process(*room)
    after = hbil.Sequence(cache=SMALL, learn=False)
    empty = after.process(*room)
    assert (empty["indirect"] != wanted["indirect"]).any()
    after.add_views([view])
    after.reset()
    before.reset()
    same(after.process(*room), before.process(*room))
    after.reset_cache()
    after.move_cache((0, 0, 3))
    after.process(*room)


def test_close_leaves_all_views(room):
    depth, normal, albedo, direct, camera = room
    one = hbil.View(*room)
    other = hbil.View(0 * depth, normal, albedo, direct, camera)  # only sky
    sequence = hbil.Sequence(cache=SMALL, views=[one], learn=False)
    sequence.process(*room)
    sequence.add_views([other])
    sequence.close()
    both = hbil.Sequence(cache=SMALL, views=[one, other], learn=False)
    same(sequence.process(*room), both.process(*room))


def test_close_waits_for_the_frame_of_another_thread(room):
    sequence = hbil.Sequence(cache=SMALL)
    with ThreadPoolExecutor() as pool:
        frames = [pool.submit(sequence.process, *room) for _ in range(20)]
        while not all(frame.done() for frame in frames):
            sequence.close()
            time.sleep(0.003)
    assert all(np.isfinite(frame.result()["beauty"]).all() for frame in frames)


def test_a_failed_first_frame_is_none(room):
    sequence = hbil.Sequence(cache=False)
    with pytest.raises(ValueError, match="^out: 'x'"):
        sequence.process(*room, out={"x": 1})
    same(sequence.process(*room), hbil.Sequence(cache=False).process(*room))


def test_vectors_have_three_numbers(room):
    with pytest.raises(TypeError, match="^cache centre: "):
        hbil.Sequence(cache={**SMALL, "centre": (1,)}).process(*room)
    sequence = hbil.Sequence(cache=SMALL)
    sequence.process(*room)
    with pytest.raises(TypeError, match=r"^centre: \(1,\); 3 numbers"):
        sequence.move_cache((1,))
    with pytest.raises(TypeError, match="^low: 0; 3 numbers"):
        sequence.forget_in_cache(light=1, low=0, high=(1, 1, 1))
    with pytest.raises(TypeError, match="^camera hardware_depth: .* 2 numbers"):
        hbil.process(*room[:4], {**room[4], "hardware_depth": [1]})


def test_views_have_their_own_size_types_and_light(room):
    depth, normal, albedo, direct, camera = room
    small = {name: value / 2 for name, value in camera.items()}
    view = hbil.View(depth[::2, ::2].astype(np.float64), normal[::2, ::2], 0.5,
                     np.zeros((HEIGHT // 2, WIDTH // 2, 3)), small)
    hbil.Sequence(cache=SMALL, views=[view]).process(*room)
    for light in "direct", "finished":
        shown = hbil.View(depth, normal, albedo, direct, camera, light=light)
        found = hbil.Sequence(cache=SMALL, views=[shown], learn=False).process(
            depth, normal, albedo, 0 * direct, camera)
        assert found["far_irradiance"].mean() > 0.01


def test_maps_from_lights(room):
    sequence = hbil.Sequence(cache=SMALL, cache_method="rsm",
                             light_views=[hbil.View(*room)])
    assert sequence.process(*room)["far_irradiance"].mean() > 0.01


def test_motion_and_shared_slices(room):
    still = np.zeros((HEIGHT, WIDTH, 2))
    sequence = hbil.Sequence(cache=False, reprojection="motion", slice_frames=4)
    for _ in range(3):
        found = sequence.process(*room, motion=still)
    assert np.isfinite(found["indirect"]).all()


def test_sizes_may_change(room):
    small = hbil.demo.room(WIDTH // 2, HEIGHT // 2)
    sequence = hbil.Sequence(cache=False, warm_up=0)
    first = sequence.process(*small)
    with pytest.raises(ValueError, match="^out: 'x'"):  # and it goes on
        sequence.process(*room, out={"x": 1})
    large = [sequence.process(*room, static=static) for static in (False, True)]
    assert large[0]["ao"].shape == (HEIGHT, WIDTH)
    again = sequence.process(*small)
    assert again["ao"].shape == first["ao"].shape
    # as if all frames had been small: light goes on bouncing
    like = hbil.Sequence(cache=False, warm_up=0)
    wanted = [like.process(*small)["indirect"].mean() for _ in range(4)]
    np.testing.assert_allclose(again["indirect"].mean(), wanted[3], rtol=0.05)
    assert again["indirect"].mean() > 1.05 * wanted[1]
    cached = hbil.Sequence(cache=SMALL)
    for picture in small, room, hbil.demo.room(WIDTH - 8, HEIGHT):
        found = cached.process(*picture)
        assert found["ao"].shape == picture[0].shape
        assert cached.sanitized()["depth"] == 0


def test_figures(room):
    sequence = hbil.Sequence(cache=False, profiling=True)
    with pytest.raises(ValueError, match="no frame"):
        sequence.sanitized()
    depth, normal, albedo, direct, camera = room
    broken = albedo.copy()
    broken[0, :3] = np.nan
    with pytest.warns(UserWarning, match="replaced: albedo 3$"):
        sequence.process(depth, normal, broken, direct, camera)
    assert sequence.sanitized()["albedo"] == 3
    assert sequence.timings()["gather"] > 0


def test_messages_name_the_argument(room):
    depth, normal, albedo, direct, camera = room
    sequence = hbil.Sequence(cache=False)
    sequence.process(*room)
    with pytest.raises(TypeError, match="^normal: an array is needed, because"):
        hbil.Sequence().process(depth, None, albedo, direct, camera)
    with pytest.raises(TypeError, match=r"^views\[1\]: int; an hbil.View"):
        hbil.Sequence(views=[hbil.View(*room), 3])
    with pytest.raises(TypeError, match="^light_views: int; a list of hbil.View"):
        hbil.Sequence(light_views=3)
    with pytest.raises(TypeError, match="^views: int; a list"):
        sequence.add_views(3)
    with pytest.raises(TypeError, match="^cache: str; True, False or a dict"):
        hbil.Sequence(cache="a")
    with pytest.raises(ValueError, match="^albedo: all frames need it or none"):
        sequence.process(depth, normal, None, direct, camera)
    with pytest.raises(ValueError, match="no radiance cache"):
        sequence.save_cache()
    for cache, kind, message in (
            ({"size": 1}, ValueError, "^cache: 'size'; of"),
            ({"voxels": "many"}, TypeError, "^cache voxels: 'many'"),
            ({"bytes": 3}, TypeError, "^cache bytes: int; those that"),
            ({"voxel_size": -1}, hbil.Error, "voxel_size")):
        with pytest.raises(kind, match=message):
            hbil.Sequence(cache=cache).process(*room)
    view = hbil.View(depth, normal[:5], albedo, direct, camera)
    with pytest.raises(ValueError, match=r"^views\[0\] normal: 48 x 5 pixels"):
        hbil.Sequence(views=[view]).process(*room)
    view = hbil.View(*room, emission=1.0)
    with pytest.raises(ValueError, match=r"^views\[0\] emission: frames have"):
        hbil.Sequence(views=[view]).process(*room)
    # a failure leaves the sequence as it was
    assert sequence.process(*room)["ao"].shape == (HEIGHT, WIDTH)

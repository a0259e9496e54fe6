"""One picture: results, arguments, messages."""
import json
import os
import subprocess
import sys
import typing
import warnings

import numpy as np
import pytest

import hbil
import hbil.demo
from hbil._library import lib

from conftest import HEIGHT, WIDTH, same
import exr


def test_results_are_sane(lit):
    assert list(lit) == ["near_irradiance", "far_irradiance", "ao",
                         "bent_normal", "cone_cosine", "indirect", "beauty"]
    for name, layer in lit.items():
        channels = hbil.LAYERS[name]
        assert layer.shape == (HEIGHT, WIDTH) + ((3,) if channels == 3 else ())
        assert layer.dtype == np.float32 and np.isfinite(layer).all()
    assert 0.3 < lit["ao"].mean() < 0.95
    # the red wall is on the left, and its light at the back wall, too
    back = lit["indirect"][HEIGHT // 2]
    assert back[14, 0] > 1.2 * back[14, 1]
    assert back[33, 1] > 1.2 * back[33, 0]


def test_layers_on_request(room, lit):
    wanted = ["glossy", "unknown", "error_estimate", "ao"]
    found = hbil.process(*room, layers=wanted)
    assert sorted(found) == sorted(wanted)
    for name in wanted:
        channels = hbil.LAYERS[name]
        assert found[name].shape[2:] == (() if channels == 1 else (channels,))
        # all channels of all pixels are written
        assert (found[name].reshape(-1, channels) != 0).mean(0).min() > 0.5, name
    # plans with glossy add up slices in another order
    np.testing.assert_allclose(found["ao"], lit["ao"], atol=2e-5)


def test_same_bits_again_and_after_another_picture(room, lit):
    depth, normal, albedo, direct, camera = room
    hbil.process(depth, normal, albedo, 2 * direct, camera)
    same(hbil.process(*room), lit)


@pytest.mark.skipif("HBIL" not in os.environ, reason="HBIL names no hbil")
def test_same_bits_as_the_tool(tmp_path):
    tool = os.environ["HBIL"]
    subprocess.run([tool, "demo", "--frames", "1", "--size", "96x64", "-o",
                    str(tmp_path / "demo")], check=True, capture_output=True)
    source = tmp_path / "demo/gbuffer/frame_0001.exr"
    subprocess.run([tool, "process", "--quiet", "-o", str(tmp_path / "lit"),
                    str(source)], check=True)
    planes = exr.read(source)

    def stack(name, components="RGB"):
        return np.stack([planes[f"{name}.{c}"] for c in components], axis=-1)
    camera = json.loads(source.with_suffix(".json").read_text())
    found = hbil.process(
        planes["depth.Z"], stack("normal", "XYZ"), stack("albedo"),
        stack("direct"), {"view_to_world": camera["camera_to_world"],
                          "opengl": True, **{name: camera[name] for name in
                                             ("fx", "fy", "cx", "cy")}},
        emission=stack("emission"), normal_space="world")
    planes = exr.read(tmp_path / "lit" / source.name)
    components = {"bent_normal": "XYZ", "ao": "V", "cone_cosine": "V"}
    same(found, {name: stack(name, components.get(name, "RGB")).reshape(
        found[name].shape) for name in found})


LAYOUTS = {
    "planar": lambda a: np.moveaxis(
        np.ascontiguousarray(np.moveaxis(a, -1, 0)), 0, -1),
    "fortran": np.asfortranarray,
    "every second": lambda a: np.repeat(np.repeat(a, 2, 0), 2, 1)[::2, ::2],
    "backwards": lambda a: np.ascontiguousarray(a[::-1, ::-1])[::-1, ::-1],
    "in four channels": lambda a: np.concatenate([a, a], -1)[..., :3],
    "read-only": lambda a: np.broadcast_to(a, (1,) + a.shape)[0],
    "foreign order": lambda a: a.astype(a.dtype.newbyteorder()),
    "doubles": lambda a: a.astype(np.float64),
    "long doubles": lambda a: a.astype(np.longdouble),
    "lists": lambda a: a.tolist(),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_any_layout_has_the_same_bits(room, lit, layout):
    change = LAYOUTS[layout]
    depth, normal, albedo, direct, camera = room
    depth = depth if layout in ("planar", "in four channels") else change(depth)
    same(hbil.process(depth, change(normal), change(albedo), change(direct),
                      camera), lit)


def test_bytes_and_halves_are_read_as_the_header_says(room):
    depth, normal, albedo, direct, camera = room
    stored = np.rint(albedo * 255).astype(np.uint8)
    found = hbil.process(depth, normal, stored, direct, camera)
    wanted = hbil.process(depth, normal, stored / 255, direct, camera)
    np.testing.assert_allclose(found["beauty"], wanted["beauty"], rtol=1e-5,
                               atol=1e-5)
    stored = np.full(albedo.shape, 188, np.uint8)
    linear = ((188 / 255 + 0.055) / 1.055) ** 2.4
    found = hbil.process(depth, normal, stored, direct, camera, srgb=["albedo"])
    wanted = hbil.process(depth, normal, linear, direct, camera)
    # radiance is stored in words, and a last bit may round to another one
    np.testing.assert_allclose(found["beauty"], wanted["beauty"], rtol=5e-4)
    half = hbil.process(depth, normal, albedo.astype(np.float16), direct, camera,
                        dtype=np.float16)
    assert half["beauty"].dtype == np.float16
    full = hbil.process(depth, normal, albedo.astype(np.float16), direct, camera)
    np.testing.assert_allclose(half["beauty"], full["beauty"], rtol=2**-10)


def test_colours_may_be_numbers(room):
    depth, normal, _, direct, camera = room
    grey = np.full(normal.shape, 0.5)
    wanted = hbil.process(depth, normal, grey, direct, camera)
    same(hbil.process(depth, normal, 0.5, direct, camera), wanted)
    same(hbil.process(depth, normal, (0.5, 0.5, 0.5), direct, camera), wanted)


def test_one_colour_in_bytes_is_that_of_a_picture_of_them(room):
    depth, normal, _, direct, camera = room
    wanted = hbil.process(depth, normal, np.full(direct.shape, 128, np.uint8),
                          direct, camera)
    for albedo in np.uint8(128), np.full(3, 128, np.uint8):
        same(hbil.process(depth, normal, albedo, direct, camera), wanted)
    same(hbil.process(depth, normal, np.uint8(188), direct, camera,
                      srgb=["albedo"]),
         hbil.process(depth, normal, np.full(direct.shape, 188, np.uint8),
                      direct, camera, srgb=["albedo"]))


def test_masks_are_not_dropped(room):
    with pytest.raises(TypeError, match="^depth: a masked array"):
        hbil.process(np.ma.masked_greater(room[0], 1), *room[1:])


def test_cameras_mean_the_same(room):
    depth, normal, albedo, direct, camera = room
    world = np.array([[0, 0, 1, 3], [-1, 0, 0, 2], [0, -1, 0, 1], [0, 0, 0, 1]])
    by_numbers = dict(camera, view_to_world=world)
    # OpenGL's view space: y and z the other way round
    turned = world @ np.diag([1, -1, -1, 1])
    by_opengl = dict(camera, view_to_world=turned, opengl=True)
    fx, fy = camera["fx"], camera["fy"]
    projection = [[2 * fx / WIDTH, 0, 0, 0], [0, 2 * fy / HEIGHT, 0, 0],
                  [0, 0, -1, -0.1], [0, 0, -1, 0]]
    by_matrices = {"projection": projection, "view": np.linalg.inv(turned)}
    normal = normal @ world[:3, :3].T
    wanted = hbil.process(depth, normal, albedo, direct, by_numbers,
                          normal_space="world")
    for other in by_opengl, by_matrices:
        found = hbil.process(depth, normal, albedo, direct, other,
                             normal_space="world")
        for name in wanted:
            np.testing.assert_allclose(found[name], wanted[name], rtol=2e-3,
                                       atol=2e-3, err_msg=name)


def test_hardware_depth_by_a_projection(room, lit):
    depth, normal, albedo, direct, camera = room
    projection = np.array([
        [2 * camera["fx"] / WIDTH, 0, 0, 0], [0, 2 * camera["fy"] / HEIGHT, 0, 0],
        [0, 0, 0, 0.1], [0, 0, 1, 0]])  # reversed, far plane at infinity
    found = hbil.process(0.1 / depth, normal, albedo, direct,
                         {"projection": projection,
                          "conventions": ["reversed_depth"]},
                         depth_kind="hardware", layers=["ao"])
    np.testing.assert_allclose(found["ao"], lit["ao"], atol=2e-3)


@pytest.mark.filterwarnings("ignore:normal")
def test_environments(room):
    depth, normal, albedo, _, camera = room
    open_sky = np.full((HEIGHT, WIDTH), 5.0)
    open_sky[: HEIGHT // 2] = 0
    up = np.zeros(normal.shape)
    up[..., 1] = -1
    white = hbil.process(open_sky, up, 1, 0, camera, environment=(1, 1, 1))
    harmonics = np.zeros((9, 3))
    harmonics[0] = np.sqrt(4 * np.pi)
    for other in harmonics, np.ones((8, 16, 3)):
        found = hbil.process(open_sky, up, 1, 0, camera, environment=other)
        np.testing.assert_allclose(found["far_irradiance"],
                                   white["far_irradiance"], rtol=0.02, atol=0.02)
    nothing = hbil.process(open_sky, up, 1, 0, camera, far_field="none")
    assert nothing["far_irradiance"].max() == 0 < white["far_irradiance"].max()


def test_options_are_those_of_the_library(room, lit):
    options = hbil.options()
    assert options["slices"] == 4 and options["mode"] == "hbil"
    del options["gather_emission"]  # which the picture decides otherwise
    same(hbil.process(*room, **options), lit)
    assert list(hbil.process(*room, mode="gtao", far_field="none",
                             environment=None)) == [
        "far_irradiance", "ao", "bent_normal", "cone_cosine", "indirect",
        "beauty"]


def test_words_of_the_tool_mean_the_same(room, lit):
    depth, normal, albedo, direct, camera = room
    same(hbil.process(depth, normal * (1, -1, -1), albedo, direct, camera,
                      normal_space="camera", sample_grid="full-resolution"), lit)
    same(hbil.process(depth, -normal, albedo, direct, camera, direct_kind="light",
                      direct_scale=0.5, normal_space="camera",
                      normal_scale=(-1, 1, 1)),
         hbil.process(depth, normal, albedo, direct, camera,
                      direct_scale=np.pi / 2))


def test_results_in_given_arrays(room, lit):
    ao = np.empty((HEIGHT, WIDTH), np.float32)
    found = hbil.process(*room, out={"ao": ao})
    assert found["ao"] is ao
    same(found, lit)


BAD = {  # arguments that replace those of the room, exception and message
    "no depth": ({"depth": None}, TypeError, "depth: an array is needed"),
    "shape": ({"depth": np.ones(5)}, ValueError,
              "depth: shape (5,); (height, width) is needed"),
    "empty": ({"depth": np.ones((0, 4))}, ValueError, "depth: shape (0, 4)"),
    "channels": ({"normal": np.ones((HEIGHT, WIDTH))}, ValueError,
                 "normal: shape (32, 48); (32, 48, 3) is needed"),
    "size": ({"albedo": np.ones((2, 3, 3))}, ValueError,
             "albedo: 3 x 2 pixels; 48 x 32 are needed"),
    "colour": ({"direct": [1, 2]}, ValueError, "direct: shape (2,)"),
    "complex": ({"direct": np.ones((HEIGHT, WIDTH, 3), complex)}, TypeError,
                "direct: dtype complex128; floats or integers are needed"),
    "text": ({"albedo": "white"}, TypeError, "albedo: dtype <U5"),
    "ragged": ({"depth": [[1, 2], [3]]}, TypeError, "depth: "),
    "camera": ({"camera": 3}, TypeError, "camera: int; a dict is needed"),
    "no focal length": ({"camera": {}}, ValueError,
                        "camera: fx or projection is needed"),
    "camera's key": ({"camera": {"fx": 1, "fz": 2}}, ValueError, "camera: 'fz'"),
    "camera's number": ({"camera": {"fx": "wide"}}, TypeError,
                        "camera fx: 'wide'; a number is needed"),
    "matrix": ({"camera": {"fx": 1, "view_to_world": np.eye(3)}}, ValueError,
               "camera view_to_world: shape (3, 3); (4, 4) is needed"),
    "option": ({"radios": 2}, TypeError, "radios: no such option"),
    "word": ({"mode": "ssao"}, ValueError,
             "mode: 'ssao'; one of hbil, gtao, hbao is needed"),
    "number": ({"radius": "far"}, TypeError, "radius: 'far'; a number is needed"),
    "whole number": ({"slices": 2.5}, TypeError, "slices: 2.5; a whole number"),
    "negative": ({"slices": -1}, TypeError, "slices: -1; a whole number"),
    "numbers": ({"facing_fade": (1,)}, TypeError,
                "facing_fade: (1,); 2 numbers are needed"),
    "layer": ({"layers": ["aoo"]}, ValueError, "layers: 'aoo'"),
    "a layer's name": ({"layers": "ao"}, TypeError,
                       "layers: 'ao'; a list of names is needed"),
    "no list of layers": ({"layers": 3}, TypeError, "layers: 3; a list"),
    "no name of a layer": ({"layers": [["ao"]]}, ValueError,
                           "layers: ['ao']; of near"),
    "no word": ({"mode": ["hbil"]}, ValueError, "mode: ['hbil']; one of hbil, g"),
    "warm_up": ({"warm_up": "a"}, TypeError, "warm_up: 'a'; a whole number"),
    "warm_up in parts": ({"warm_up": 2.5}, TypeError, "warm_up: 2.5; a whole"),
    "warm_up backwards": ({"warm_up": -1}, TypeError, "warm_up: -1; a whole"),
    "sky_share": ({"sky_share": "s"}, TypeError, "sky_share: 's'; a number"),
    "no dtype": ({"dtype": "x"}, TypeError, "dtype: 'x'; float32 or float16"),
    "device's kind": ({"device": 2.5}, TypeError, "device: 2.5; an index or"),
    "device's list": ({"device": [1]}, TypeError, "device: [1]; an index or"),
    "queue": ({"queue": "q"}, TypeError, "queue: str; a CommandQueue"),
    "a name for srgb": ({"srgb": "albedo"}, TypeError, "srgb: 'albedo'; a list"),
    "srgb of depth": ({"srgb": ["depth"]}, ValueError, "srgb: 'depth'; of albedo"),
    "out's kind": ({"out": "ao"}, TypeError, "out: str; a dict"),
    "no layer": ({"layers": []}, ValueError, "layers: at least one"),
    "dtype": ({"dtype": np.float64}, TypeError, "dtype: float64"),
    "device": ({"device": "no such"}, ValueError, "device: 'no such'"),
    "srgb": ({"srgb": ["albedo"]}, TypeError, "albedo: dtype float32; uint8"),
    "environment": ({"environment": (1, 2)}, ValueError, "environment: shape"),
    "out": ({"out": {"ao": np.ones(3)}}, ValueError, "out ao: float64"),
    "out's name": ({"out": {"a": 1}}, ValueError, "out: 'a' is none"),
    "the library's": ({"slices": 0}, hbil.Error, "sampling.slices"),
    "the library's camera": ({"camera": {"fx": -1}}, hbil.Error, "fx"),
    "the library's matrix": ({"camera": {"projection": np.zeros((4, 4))}},
                             hbil.Error, "projection"),
}


@pytest.mark.parametrize("case", BAD)
def test_messages_name_the_argument(room, case):
    changes, kind, message = BAD[case]
    given = dict(zip(("depth", "normal", "albedo", "direct", "camera"), room))
    with pytest.raises(kind) as caught:
        hbil.process(**{**given, **changes})
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    if kind is hbil.Error:
        assert caught.value.status.startswith("HBIL_")
    else:
        assert str(caught.value).startswith(message.split(":")[0])


def told(light, *picture, **options):
    with pytest.warns(UserWarning) as caught:
        light(*picture, **options)
    assert len(caught) == 1 and caught[0].filename == __file__
    return str(caught[0].message)


def test_what_cannot_be_meant_is_told_in_one_warning(room):
    depth, normal, albedo, direct, camera = room
    u, v = np.meshgrid(*((np.arange(n) + 0.5 - n / 2) / camera["fx"]
                         for n in (WIDTH, HEIGHT)))
    ray = depth * np.sqrt(u * u + v * v + 1)
    turned = np.array([[.36, .48, -.8, 0], [-.8, .6, 0, 0], [.48, .64, .6, 0],
                       [0, 0, 0, 1]])
    world = normal @ turned[:3, :3].T
    placed = {**camera, "view_to_world": turned}
    up = {**camera, "view_to_world": turned @ np.diag([1, -1, -1, 1])}
    for depths, normals, eye, options, message in (
            (depth, normal * (1, -1, -1), camera, {},
             'normal: doesn\'t fit depth, but would with normal_space="view", '
             "normal_scale=(1, -1, -1)"),
            (depth, world, placed, {},
             'normal_space="world", normal_scale=(1, 1, 1)'),
            (depth, world, up, {"normal_space": "world"},
             'normal_space="world", camera opengl=True, normal_scale=(1, 1, 1)'),
            (depth, normal @ np.array([[.6, .8, 0], [-.8, .6, 0], [0, 0, 1]]),
             camera, {}, "degrees off on average"),
            (depth, normal / 2 + 0.5, camera, {}, "normal: stored as (n + 1)"),
            (ray, normal, camera, {}, 'would with depth_kind="ray"'),
            (depth, normal, camera, {"depth_kind": "ray"},
             'would with depth_kind="planar"')):
        assert message in told(hbil.process, depths, normals, albedo, direct,
                               eye, **options)
    broken = [array.copy() for array in room[:4]]
    for pixels, array in enumerate(broken):
        array[5, :pixels + 1] = np.nan
    broken[1][6, 0] = 0
    sequence = hbil.Sequence(cache=False, views=[hbil.View(
        depth, -normal, albedo, direct, camera)])
    message = told(sequence.process, *broken, camera)
    assert message.startswith("views[0] normal: doesn't fit depth, but")
    assert message.endswith("replaced: depth 1, normal 2, albedo 2, direct 3")
    with warnings.catch_warnings():  # nothing more, and nothing of the right ones
        warnings.simplefilter("error")
        sequence.process(*broken, camera)
        for depths, normals, eye, options in (
                (ray, normal, camera, {"depth_kind": "ray"}),
                (depth, world, {**up, "opengl": True}, {"normal_space": "world"}),
                (depth, -2 * normal, camera, {"normal_scale": (-3, -3, -3)})):
            hbil.process(depths, normals, albedo, direct, eye, **options)


def test_hints_can_be_read():
    for function in hbil.process, hbil.Sequence.__init__, hbil.Sequence.process:
        assert typing.get_type_hints(function)["return"]


def test_version():
    assert hbil.version() == ".".join(
        str(getattr(lib, f"HBIL_VERSION_{part}"))
        for part in ("MAJOR", "MINOR", "PATCH"))


def test_children_of_fork_are_told():
    done = subprocess.run([sys.executable, "-c", """
import os, hbil, hbil.demo
hbil.process(*hbil.demo.room(48, 32))
if os.fork() == 0:
    try:
        hbil.process(*hbil.demo.room(48, 32))
    except hbil.Error as error:
        os._exit(7 if "fork" in str(error) else 1)
    os._exit(1)
raise SystemExit(os.waitstatus_to_exitcode(os.wait()[1]))"""])
    assert done.returncode == 7


def test_pictures(tmp_path, lit):
    hbil.demo.save(str(tmp_path / "ao.png"), lit["ao"])
    assert (tmp_path / "ao.png").read_bytes()[:4] == b"\x89PNG"
    assert hbil.demo.picture(np.array([[0, 1, np.nan]])).tolist() == [
        [[0] * 3, [255] * 3, [0] * 3]]

"""How large a place is, by what pictures of it show: the middle and the voxels
of a radiance cache, as `hbil process` chooses them (src/tool/extent.c)."""
from __future__ import annotations

from typing import Any, Iterable, Mapping, Tuple

import numpy as np

from ._arrays import Plane, values
from ._library import lib

_LOOKS = 4096  # pixels of a picture, about
# All but this share of the surfaces lie inside, since single far ones would
# make voxels too wide for all others.
_MOST_SURFACES = 0.995

Picture = Tuple[Mapping[str, Plane], Any, Any]  # planes, frame, configuration


def view_points(picture: Picture, rows: np.ndarray,
                columns: np.ndarray) -> np.ndarray:
    """The points of some pixels in view space, by x, y and z; NaN where there is
    no surface."""
    planes, frame, config = picture
    inputs, camera, plane = config.inputs, frame.camera, planes["depth"]
    array = plane.array.get() if plane.on_device else plane.array
    stored = values("depth", plane._replace(array=array.reshape(
        array.shape[:2])[rows[:, None], columns])).astype(np.float64)
    u = (columns + 0.5 - camera.cx) / camera.fx
    v = (rows[:, None] + 0.5 - camera.cy) / camera.fy
    orthographic = inputs.projection == lib.HBIL_PROJECTION_ORTHOGRAPHIC
    with np.errstate(all="ignore"):
        depth = stored * inputs.depth_scale
        if inputs.depth_kind == lib.HBIL_DEPTH_HARDWARE:
            a, b = frame.hardware_depth
            depth = (stored - a) / b if orthographic else b / (stored - a)
        shown = np.isfinite(depth) & (depth > 0) & (depth < inputs.sky_depth) \
            & (depth < 1e15)
        if inputs.depth_kind == lib.HBIL_DEPTH_RAY and not orthographic:
            depth = depth / np.sqrt(u * u + v * v + 1)
    depth = np.where(shown, depth, np.nan)
    scale = np.where(shown, 1, np.nan) if orthographic else depth
    return np.stack([u * scale, v * scale, depth])


def _distances(picture: Picture, centre: np.ndarray) -> np.ndarray:
    """The largest coordinate of each surface from the centre, world units."""
    _, frame, config = picture
    step = max(1, int(np.sqrt(config.width * config.height / _LOOKS)))
    points = view_points(picture, np.arange(step // 2, config.height, step),
                         np.arange(step // 2, config.width, step))
    points = points[:, np.isfinite(points[2])]
    camera = frame.camera
    world = np.reshape(list(camera.world_from_view), (4, 4))
    placed = world[:3, :3] @ points + (world[:3, 3] - centre)[:, None]
    return np.abs(placed).max(axis=0, initial=0)


def choose(cache: Any, pictures: Iterable[Picture], centre_too: bool) -> None:
    """Sets voxel_size, and centre, of an hbil_cache_config.

    The middle is the first picture's camera.
    """
    pictures = list(pictures)
    if centre_too:
        cache.centre = list(pictures[0][1].camera.world_from_view)[3:12:4]
    centre = np.array(list(cache.centre))
    distances = np.concatenate([_distances(picture, centre)
                                for picture in pictures])
    radius = np.quantile(distances, _MOST_SURFACES) if distances.size else 0
    # Two voxels of the last level remain at each side, for the rounding of the
    # middle.  Without any surface the size doesn't matter.
    size = radius / (0.5 * cache.voxels - 2) / 2 ** (cache.levels - 1)
    cache.voxel_size = float(np.clip(size, 1e-6, 1e6)) if radius > 0 else 1.0

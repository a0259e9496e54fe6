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


def _depths(plane: Plane, step: int) -> np.ndarray:
    if plane.on_device:
        return plane.array.get()[step // 2::step, step // 2::step]
    return values("depth", plane._replace(
        array=plane.array[step // 2::step, step // 2::step]))


def _distances(picture: Picture, centre: np.ndarray) -> np.ndarray:
    """The largest coordinate of each surface from the centre, world units."""
    planes, frame, config = picture
    inputs, camera = config.inputs, frame.camera
    step = max(1, int(np.sqrt(config.width * config.height / _LOOKS)))
    stored = np.array(_depths(planes["depth"], step), np.float64).reshape(
        len(range(step // 2, config.height, step)), -1)
    y, x = np.mgrid[step // 2:config.height:step, step // 2:config.width:step]
    u, v = (x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy
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
        scale = np.ones_like(depth) if orthographic else depth
        points = np.stack([u * scale, v * scale, depth])[:, shown]
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

"""What is probably wrong with a picture: whether its normals fit its depth, by
pixels of a grid, as `hbil info` finds it (src/dump/normal_fit.c,
check_normals.c), and which values the library has replaced."""
from __future__ import annotations

from typing import Any, List, Mapping, NamedTuple, Tuple

import numpy as np

from ._arrays import values
from ._extent import Picture, view_points
from ._library import ffi, lib

_LOOKS = 48  # rows or columns of the grid, about
_LEAST = 200  # fewer pixels of smooth surfaces say nothing
# Signs of the axes, the likelier ones first
_SIGNS = [(1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1), (1, -1, -1),
          (-1, 1, -1), (-1, -1, 1), (-1, -1, -1)]


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.sqrt((vectors * vectors).sum(0))


class _Fit(NamedTuple):
    """The mean of g n^T over smooth surfaces, where n is a normal as it is
    stored and g that of the depth, in view space; and the same for the other
    kind of depth.  A matrix H that brings n into view space makes the mean
    cosine between both the sum of H times that mean."""
    count: int
    planar: np.ndarray
    other: np.ndarray
    encoded: float  # the share of n that are of unit length as 2n - 1


def _stored_normals(picture: Picture, rows: np.ndarray,
                    columns: np.ndarray) -> np.ndarray:
    plane = picture[0]["normal"]
    array = plane.array if plane.planar else plane.array.transpose(2, 0, 1)
    return np.array(values("normal", plane._replace(
        array=array[:, rows[:, None], columns])), np.float64)


def _measure(picture: Picture) -> _Fit:
    _, _, config = picture
    height, width = config.height, config.width
    stride, step = min(height, width) // _LOOKS + 1, width // 200 + 1
    rows = np.arange(step, height - step, stride)
    columns = np.arange(step, width - step, stride)
    middle, left, right, up, down = (
        view_points(picture, rows + step * y, columns + step * x)
        for x, y in ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)))
    parallel = config.inputs.projection == lib.HBIL_PROJECTION_ORTHOGRAPHIC
    ray = config.inputs.depth_kind == lib.HBIL_DEPTH_RAY

    def smooth(before: np.ndarray, after: np.ndarray) -> np.ndarray:
        # what of a plane's depth is linear over the picture
        a, b, c = (p[2] if parallel else 1 / p[2]
                   for p in (before, middle, after))
        return np.abs(a + c - 2 * b) <= 0.1 * np.abs(c - a) + 1e-3 * b

    def other(point: np.ndarray) -> np.ndarray:
        length = 1 if parallel else np.sqrt((point * point).sum(0)) / point[2]
        return point * length if ray else point / length
    normal = _stored_normals(picture, rows, columns)
    coded = (normal >= 0).all(0) & (normal <= 1).all(0) & (np.abs(np.sqrt(
        ((2 * normal - 1) ** 2).sum(0)) - 1) < 0.05) & (np.abs(np.sqrt(
            (normal * normal).sum(0)) - 1) > 0.01)
    some = (normal != 0).any(0).sum()
    normal = _unit(normal)
    gradients = [_unit(np.cross(b - a, d - c, axis=0)) for a, b, c, d in (
        (up, down, left, right), map(other, (up, down, left, right)))]
    good = smooth(left, right) & smooth(up, down) & np.isfinite(
        normal + sum(gradients)).all(0)
    count = int(good.sum())
    planar, other_kind = (g[:, good] @ normal[:, good].T / max(count, 1)
                          for g in gradients)
    return _Fit(count, planar, other_kind, coded.sum() / max(some, 1))


def _turned(fit: _Fit, agreement: float, to_view: Mapping[str, np.ndarray]
            ) -> str:
    """Where the normals would fit much better; "": nowhere."""
    best, found = agreement + 0.1, ""  # bump maps differ by less
    for space, rotation in to_view.items():
        for signs in _SIGNS:
            fits = (rotation * signs * fit.planar).sum()
            if fits > best and fits > 0.9:
                best = fits + 1e-3  # equally good is not better
                found = f"{space}, normal_scale={signs}"
    return found


def fit_of_normals(picture: Picture, camera: Mapping[str, Any]) -> List[str]:
    """What is probably wrong, as sentences, by planes in host memory."""
    planes, frame, config = picture
    inputs = config.inputs
    if "normal" not in planes or planes["normal"].on_device \
            or planes["depth"].on_device \
            or inputs.normal_encoding == lib.HBIL_NORMAL_OCTAHEDRAL:
        return []
    with np.errstate(all="ignore"):
        fit = _measure(picture)
    if fit.encoded > 0.9:
        return ["normal: stored as (n + 1) / 2; 2 * normal - 1 is needed"]
    if fit.count < _LEAST:
        return []
    from_world = np.reshape(list(frame.camera.world_from_view),
                            (4, 4))[:3, :3].T
    to_view = {'normal_space="view"': np.eye(3),
               'normal_space="world"': from_world}
    if "projection" not in camera:
        to_view[f'normal_space="world", camera opengl='
                f'{not camera.get("opengl")}'] = np.diag(
                    (1, -1, -1)) @ from_world
    is_world = inputs.normal_space == lib.HBIL_SPACE_WORLD
    as_told = (from_world if is_world else np.eye(3)) * np.sign(
        list(inputs.normal_scale))
    agreement = (as_told * fit.planar).sum()
    turned = _turned(fit, agreement, to_view)
    if turned:
        return [f"normal: doesn't fit depth, but would with {turned}"]
    off, off_other = 1 - agreement, 1 - (as_told * fit.other).sum()
    hardware = inputs.depth_kind == lib.HBIL_DEPTH_HARDWARE
    if not hardware and off > 1e-3 and 3 * off_other < off:
        kind = "planar" if inputs.depth_kind == lib.HBIL_DEPTH_RAY else "ray"
        return ["depth: doesn't fit the normals, but would with "
                f'depth_kind="{kind}"']
    if agreement <= 0.9:
        degrees = np.degrees(np.arccos(max(-1.0, agreement)))
        return [f"normal: doesn't fit depth ({degrees:.0f} degrees off on "
                "average): another camera, depth_kind or normal_space?"]
    return []


def replaced(counts: Mapping[str, int]) -> List[str]:
    """The same of hbil_sanitized.  Normals that face away are for the fit."""
    found = [f"{name} {count}" for name, count in counts.items()
             if count and name != "facing_away"]
    return found and [
        "pixels whose values mean nothing (NaN, infinite, negative, albedo "
        "above 1, normals of length 0) were replaced: " + ", ".join(found)]

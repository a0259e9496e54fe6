"""A room to try things with, and pictures of results.

    import hbil, hbil.demo
    layers = hbil.process(*hbil.demo.room())
    hbil.demo.save("room.png", layers["beauty"])
"""
from __future__ import annotations

import struct
import zlib
from typing import Any, Dict, Tuple

import numpy as np

# World units; x right, y down, z forward.  The camera is at the origin.
_LOW, _HIGH = np.array([-2.0, -1.5, -1.0]), np.array([2.0, 1.5, 5.0])
_BLOCK = np.array([[-0.9, 0.3, 2.6], [0.3, 1.5, 3.8]])
_LAMP = np.array([0.6, -1.3, 2.4])
_POWER = 40.0  # W/sr
_WHITE, _RED, _GREEN = (0.75, 0.75, 0.75), (0.65, 0.06, 0.05), (0.12, 0.45, 0.1)


def _slabs(origin: np.ndarray, ray: np.ndarray, low: np.ndarray,
           high: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Where rays enter and leave each pair of parallel faces."""
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (low - origin) / ray, (high - origin) / ray
    return np.fmin(a, b), np.fmax(a, b)


def room(width: int = 640, height: int = 360, lamp: Any = _LAMP
         ) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray,
                    Dict[str, float]]:
    """depth, normal, albedo, direct and camera of a room with a block, which a
    small lamp lights: the first arguments of hbil.process()."""
    focal = 0.6 * width
    x, y = np.meshgrid((np.arange(width) + 0.5 - width / 2) / focal,
                       (np.arange(height) + 0.5 - height / 2) / focal)
    ray = np.stack([x, y, np.ones_like(x)], axis=-1)
    origin = np.zeros(3)
    # the block where the ray meets it, else the room's walls from inside
    enter, leave = _slabs(origin, ray, *_BLOCK)
    on_block = enter.max(-1) < leave.min(-1)
    depth = np.where(on_block, enter.max(-1),
                     _slabs(origin, ray, _LOW, _HIGH)[1].min(-1))
    axis = np.where(on_block, enter.argmax(-1),
                    _slabs(origin, ray, _LOW, _HIGH)[1].argmin(-1))
    normal = -np.eye(3)[axis] * np.sign(ray)
    albedo = np.full_like(ray, _WHITE)
    walls = ~on_block & (axis == 0)
    albedo[walls & (x < 0)], albedo[walls & (x > 0)] = _RED, _GREEN
    # the lamp, and the block's shadow; points are lifted off their surface
    point = ray * depth[..., None] + 1e-4 * normal
    to_lamp = np.asarray(lamp) - point
    distance2 = (to_lamp ** 2).sum(-1)
    cosine = np.maximum((to_lamp * normal).sum(-1), 0) / np.sqrt(distance2)
    enter, leave = _slabs(point, to_lamp, *_BLOCK)
    seen = np.maximum(enter.max(-1), 0) >= np.minimum(leave.min(-1), 1)
    irradiance = _POWER * cosine / distance2 * seen
    direct = np.repeat(irradiance[..., None], 3, axis=-1)
    camera = {"fx": focal, "fy": focal, "cx": width / 2, "cy": height / 2}
    return tuple(a.astype(np.float32)
                 for a in (depth, normal, albedo, direct)) + (camera,)


def picture(layer: Any, exposure: float = 1.0) -> np.ndarray:
    """A layer as bytes with the curve of sRGB, (height, width, 3)."""
    values = np.asarray(layer.get() if hasattr(layer, "get") else layer,
                        np.float32)
    if values.ndim == 2:
        values = np.repeat(values[..., None], 3, axis=-1)
    linear = np.clip(np.nan_to_num(exposure * values), 0, 1)
    coded = np.where(linear <= 0.0031308, 12.92 * linear,
                     1.055 * linear ** (1 / 2.4) - 0.055)
    return np.rint(255 * coded).astype(np.uint8)


def save(path: str, layer: Any, exposure: float = 1.0) -> None:
    """Writes a layer of one or three channels as a PNG; 1 / exposure becomes
    white."""
    pixels = picture(layer, exposure)
    height, width = pixels.shape[:2]
    rows = np.concatenate([np.zeros((height, 1), np.uint8),
                           pixels.reshape(height, -1)], axis=1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(
            ">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows.tobytes()))
            + chunk(b"IEND", b""))

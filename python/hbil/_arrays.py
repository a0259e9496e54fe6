"""Arrays as hbil's planes: shapes, types of components, and layouts."""
from __future__ import annotations

from typing import Any, List, NamedTuple, Optional, Tuple

import numpy as np

from ._library import ffi, lib

# Channels of a pixel.  That these are hbil_inputs' and hbil_outputs' planes is
# tested against the headers.
INPUTS = {"depth": 1, "normal": 3, "albedo": 3, "f0": 3, "direct": 3,
          "emission": 3, "motion": 2}
LAYERS = {"near_irradiance": 3, "far_irradiance": 3, "ao": 1, "bent_normal": 3,
          "cone_cosine": 1, "indirect": 3, "beauty": 3, "error_estimate": 2,
          "unknown": 1, "glossy": 3}
COLOURS = ("albedo", "f0", "direct", "emission")

_FLOATS = {np.dtype(np.float32): lib.HBIL_FLOAT32,
           np.dtype(np.float16): lib.HBIL_FLOAT16}
_UNSIGNED = {np.dtype(np.uint8): lib.HBIL_UNORM8,
             np.dtype(np.uint16): lib.HBIL_UNORM16}
_SIGNED = {np.dtype(np.int8): lib.HBIL_SNORM8,
           np.dtype(np.int16): lib.HBIL_SNORM16}
# What integers stand for, by the input; as hbil_component says
_INTEGERS = {**{name: _UNSIGNED for name in COLOURS},
             "normal": {**_UNSIGNED, **_SIGNED},
             "motion": {np.dtype(np.int16): lib.HBIL_SNORM16}}
_NAMES = ffi.typeof("hbil_component").elements


class Plane(NamedTuple):
    """An input as it goes to the library."""
    array: Any        # numpy's, contiguous; or pyopencl's
    component: int    # hbil_component
    pixel_pitch: int  # bytes, as in hbil_plane_format
    planar: bool      # each channel is an image of its own
    on_device: bool
    offset: int = 0
    row_pitch: int = 0
    plane_pitch: int = 0

    @property
    def format(self) -> Tuple[int, int]:
        return self.component, self.pixel_pitch


def is_on_device(value: Any) -> bool:
    """Whether it is an array of pyopencl."""
    return hasattr(value, "base_data") and hasattr(value, "queue")


def _component(name: str, dtype: np.dtype, hardware: bool) -> Optional[int]:
    integers = _INTEGERS.get(name, {})
    if name == "depth" and hardware:
        integers = {np.dtype(np.uint16): lib.HBIL_UNORM16}
    return _FLOATS.get(dtype, integers.get(dtype))


def _shape(name: str, value: Any, size: Optional[Tuple[int, int]],
           channels: int) -> Tuple[int, int]:
    """Checks a shape and returns height and width."""
    shape = tuple(value.shape)
    good = len(shape) == 3 and shape[2] == channels or \
        channels == 1 and len(shape) == 2
    if not good or 0 in shape:
        height, width = size or ("height", "width")
        needed = f"{height}, {width}" + (f", {channels}" if channels > 1 else "")
        raise ValueError(f"{name}: shape {shape}; ({needed}) is needed")
    if size and shape[:2] != size:
        raise ValueError(f"{name}: {shape[1]} x {shape[0]} pixels; "
                         f"{size[1]} x {size[0]} are needed")
    return shape[:2]


def _layout(value: Any, channels: int) -> Optional[Plane]:
    """The plane of an array whose pixels lie in memory as the library reads
    them, else None.  For pyopencl's arrays with gaps, too."""
    size, strides = value.dtype.itemsize, value.strides
    rows, columns = strides[0], strides[1]
    between = strides[2] if len(strides) == 3 and channels > 1 else size
    planar = channels == 1 or columns == size and between != size
    pitch = size if planar else columns
    width = value.shape[1]
    if columns < size or rows < width * pitch or (between != size if not planar
                                                  else between < size):
        return None
    return Plane(value, 0, pitch, planar, True, getattr(value, "offset", 0),
                 rows, between if channels > 1 and planar else 0)


def _device_plane(name: str, value: Any, channels: int,
                  component: Optional[int]) -> Plane:
    if component is None:
        raise TypeError(f"{name}: dtype {value.dtype} on the device; float32 or "
                        "float16 is needed")
    plane = _layout(value, channels)
    if plane is None:
        raise ValueError(f"{name}: strides {value.strides} on the device; rows "
                         "and pixels in their order are needed")
    return plane._replace(component=component)


def _host_array(name: str, title: str, value: Any,
                size: Optional[Tuple[int, int]]) -> np.ndarray:
    """An array of numbers; single colours fill the picture."""
    if np.ma.is_masked(value):
        raise TypeError(f"{title}: a masked array; filled(), with what stands "
                        "for masked pixels, is needed")
    try:
        array = np.asarray(value)
    except ValueError:
        raise TypeError(f"{title}: no array of numbers") from None
    if array.dtype.kind not in "fiub":
        raise TypeError(f"{title}: dtype {array.dtype}; floats or integers are "
                        "needed")
    if name in COLOURS and size and array.ndim < 2:
        if array.shape not in ((), (3,)):
            raise ValueError(
                f"{title}: shape {array.shape}; ({size[0]}, {size[1]}, 3), "
                "(3,) or a number is needed")
        if array.dtype not in (np.uint8, np.uint16):  # 0..255 stands for 0..1
            array = array.astype(np.float32)
        array = np.broadcast_to(array, size + (3,))
    return array


def input_plane(name: str, value: Any, size: Optional[Tuple[int, int]],
                hardware: bool = False, octahedral: bool = False,
                srgb: bool = False, title: str = "") -> Plane:
    """A plane of an argument.

    size: height and width; None: this is the one that decides them.  title: the
    argument's name for messages, if it is another one.
    """
    channels = 2 if name == "normal" and octahedral else INPUTS[name]
    title = title or name
    on_device = is_on_device(value)
    array = value if on_device else _host_array(name, title, value, size)
    _shape(title, array, size, channels)
    component = _component(name, np.dtype(array.dtype), hardware)
    if srgb:
        if array.dtype != np.uint8:
            raise TypeError(f"{title}: dtype {array.dtype}; uint8 is needed for "
                            "what is named in srgb")
        component = lib.HBIL_SRGB8
    if on_device:
        return _device_plane(title, array, channels, component)
    if channels == 1:
        array = array.reshape(array.shape[:2])
    if component is None or not array.dtype.isnative:
        array = array.astype(np.float32)
        component = lib.HBIL_FLOAT32
    item = array.dtype.itemsize
    if channels > 1 and array.transpose(2, 0, 1).flags.c_contiguous \
            and not array.flags.c_contiguous:
        return Plane(array.transpose(2, 0, 1), component, item, True, False)
    array = np.ascontiguousarray(array)
    return Plane(array, component, item * channels, channels == 1, False)


def _srgb_curve() -> np.ndarray:
    stored = np.arange(256) / 255  # IEC 61966-2-1
    return np.where(stored <= 0.04045, stored / 12.92,
                    ((stored + 0.055) / 1.055) ** 2.4).astype(np.float32)


def values(name: str, plane: Plane) -> np.ndarray:
    """What a plane in host memory stands for, as floats, in its layout."""
    array = plane.array
    if plane.component == lib.HBIL_FLOAT32:
        return array
    if plane.component == lib.HBIL_SRGB8:
        return _srgb_curve()[array]
    if array.dtype.kind == "f":
        return array.astype(np.float32)
    found = np.maximum(array / np.float32(np.iinfo(array.dtype).max), -1,
                       dtype=np.float32)
    if name == "normal" and array.dtype.kind == "u":
        found = 2 * found - 1
    return found


def convert(name: str, plane: Plane, like: Plane, title: str) -> Plane:
    """The plane with the format of another one."""
    if plane.format == like.format:
        return plane
    if like.component not in (lib.HBIL_FLOAT32, lib.HBIL_FLOAT16) and \
            plane.component != like.component:
        raise TypeError(f"{title}: {_NAMES[plane.component]}; "
                        f"{_NAMES[like.component]} is needed, as in frames")
    array = plane.array
    if plane.component != like.component:
        array = values(name, plane).astype(
            np.float16 if like.component == lib.HBIL_FLOAT16 else np.float32)
    if array.ndim == 3 and plane.planar != like.planar:
        array = np.ascontiguousarray(array.transpose(1, 2, 0) if plane.planar
                                     else array.transpose(2, 0, 1))
    if array.ndim == 3 and like.on_device and not like.planar and \
            like.pixel_pitch > array.shape[2] * array.dtype.itemsize:
        raise TypeError(f"{title}: pixels of frames have gaps on the device, so "
                        "views must be there, too")
    return Plane(array, like.component, like.pixel_pitch, like.planar, False)


def host_plane(array: np.ndarray, planar: bool) -> Tuple[List[int], int]:
    """Addresses of the channels of an array of floats, and the bytes from a
    pixel to the next, for an hbil_host_plane."""
    address = array.ctypes.data
    item = array.dtype.itemsize
    if array.ndim == 2:
        starts, pitch = [address], item
    elif planar:
        starts = [address + c * array.strides[0] for c in range(array.shape[0])]
        pitch = item
    else:
        starts = [address + c * item for c in range(array.shape[2])]
        pitch = array.strides[1]
    return starts, pitch

"""Options by the names of hbil_config's members, and cameras."""
from __future__ import annotations

import os
from typing import Any, Dict, Iterable, List, Mapping, Tuple

import numpy as np

from ._library import check, ffi, lib

# The groups of hbil_config, in its order.
_GROUPS = [name for name, field in ffi.typeof("hbil_config").fields
           if field.type.kind == "struct"]


def words(enumeration: str) -> Dict[str, int]:
    """The values of one of hbil's enums, by the last parts of their names in
    small letters: {"none": 0, "constant": 1, ...} of hbil_far_field."""
    names = ffi.typeof(enumeration).elements
    common = os.path.commonprefix(list(names.values())).rpartition("_")[0] + "_"
    return {name[len(common):].lower(): value for value, name in sorted(names.items())}


def _is_format(field: Any) -> bool:
    return field.type is ffi.typeof("hbil_plane_format")


def _members() -> Dict[str, Tuple[str, Any]]:
    """Group and type of each setting, by its member's name."""
    return {name: (group, field.type) for group in _GROUPS
            for name, field in ffi.typeof(f"hbil_{group}").fields
            if not _is_format(field)}


MEMBERS = _members()
# These stand for several members: hbil_model_set(), hbil_sampling_set().
NAMED = {"model": ("hbil_model_name", lib.hbil_model_set),
         "quality": ("hbil_quality", lib.hbil_sampling_set)}


# Words of `hbil process` for another one with factors, see apply()
_TOOL_WORDS = {("normal_space", "camera"): "view",
               ("direct_kind", "light"): "irradiance"}


def options() -> Dict[str, Any]:
    """All options of process() and Sequence, with their defaults.

    These are the members of hbil_config (hbil_config.h), and `model` and
    `quality`, which set several of them.
    """
    config = new_config()
    found: Dict[str, Any] = {"model": "default", "quality": None}
    for name, (group, kind) in MEMBERS.items():
        value = getattr(getattr(config, group), name)
        if kind.kind == "enum":
            value = next(word for word, number in words(kind.cname).items()
                         if number == value)
        elif kind.kind == "array":
            value = tuple(value)
        found[name] = value
    return found


def new_config() -> Any:
    config = ffi.new("hbil_config *")
    lib.hbil_config_init_sized(config, ffi.sizeof("hbil_config"))
    return config


def choice(name: str, value: Any, enumeration: str) -> int:
    """A word of an enum as its value; those of options of `hbil process` have -
    in place of _."""
    known = words(enumeration)
    if isinstance(value, str):
        word = _TOOL_WORDS.get((name, value), value.replace("-", "_"))
        if word in known:
            return known[word]
    raise ValueError(f"{name}: {value!r}; one of "
                     f"{', '.join(known)} is needed")


def numbers_of(name: str, value: Any, count: int) -> List[float]:
    """So many numbers, as a list: cffi would fill up what is missing."""
    try:
        numbers = [float(number) for number in value]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != count:
        raise TypeError(f"{name}: {value!r}; {count} numbers are needed")
    return numbers


def converted(name: str, value: Any, kind: Any) -> Any:
    """What a member of that type takes."""
    if kind.kind == "enum":
        return choice(name, value, kind.cname)
    if kind.kind == "array":
        return numbers_of(name, value, kind.length)
    try:
        if kind.cname in ("float", "double"):
            return float(value)
        number = int(value)
        if number != value:
            raise ValueError
        ffi.new(f"{kind.cname} *", number)  # whether it is in range
        return number
    except (TypeError, ValueError, OverflowError):
        what = ("a number" if kind.cname in ("float", "double") else
                "a whole number from 0 on")
        raise TypeError(f"{name}: {value!r}; {what} is needed") from None


def number(name: str, value: Any, kind: str = "float") -> Any:
    return converted(name, value, ffi.typeof(kind))


def names_of(name: str, value: Any, known: Iterable[str]) -> List[str]:
    """Some of those that are known."""
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise TypeError(f"{name}: {value!r}; a list of names is needed")
    for one in (found := list(value)):
        if one not in list(known):
            raise ValueError(f"{name}: {one!r}; of {', '.join(known)} are needed")
    return found


def check_names(given: Mapping[str, Any]) -> None:
    for name in given:
        if name not in MEMBERS and name not in NAMED:
            raise TypeError(f"{name}: no such option; hbil.options() has all")


def apply(config: Any, given: Mapping[str, Any]) -> None:
    """Sets options in a configuration; named sets of them first."""
    for name, (enumeration, function) in NAMED.items():
        if given.get(name) is not None:
            group = config.model if name == "model" else config.sampling
            check(function(ffi.addressof(group),
                           choice(name, given[name], enumeration)))
    for name, value in given.items():
        if name in MEMBERS:
            group, kind = MEMBERS[name]
            setattr(getattr(config, group), name, converted(name, value, kind))
    if given.get("normal_space") == "camera":  # y up, z backward
        for axis in 1, 2:
            config.inputs.normal_scale[axis] *= -1
    if given.get("direct_kind") == "light":  # E / pi
        config.inputs.direct_scale *= np.pi


def _matrix(name: str, value: Any) -> Any:
    try:
        matrix = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: numbers are needed") from None
    if matrix.shape == (3, 4):
        matrix = np.vstack([matrix, [0, 0, 0, 1]])
    if matrix.shape != (4, 4):
        raise ValueError(f"{name}: shape {matrix.shape}; (4, 4) is needed")
    return ffi.new("double[16]", matrix.ravel().tolist())


_BY_NUMBERS = ("fx", "fy", "cx", "cy", "view_to_world", "opengl")
_BY_MATRICES = ("projection", "view", "conventions")


def set_camera(frame: Any, camera: Mapping[str, Any], config: Any) -> None:
    """Fills camera and hardware_depth of an hbil_frame or an hbil_view."""
    if not isinstance(camera, Mapping):
        raise TypeError(f"camera: {type(camera).__name__}; a dict is needed")
    by_matrices = "projection" in camera
    for name in camera:
        if name not in (_BY_MATRICES if by_matrices else
                        _BY_NUMBERS + ("hardware_depth",)):
            raise ValueError(f"camera: {name!r} is not known here; "
                             f"{', '.join(_BY_NUMBERS)} or "
                             f"{', '.join(_BY_MATRICES)} are")
    to = ffi.addressof(frame, "camera")
    if by_matrices:
        flags = 0
        for word in camera.get("conventions", ()):
            flags |= choice("camera conventions", word, "hbil_matrix_convention")
        check(lib.hbil_camera_from_matrices(
            to, frame.hardware_depth, config,
            _matrix("camera projection", camera["projection"]),
            _matrix("camera view", camera.get("view", np.eye(4))), flags))
        return
    if "fx" not in camera:
        raise ValueError("camera: fx or projection is needed")
    numbers = {"fx": camera["fx"], "fy": camera.get("fy", camera["fx"]),
               "cx": camera.get("cx", config.width / 2),
               "cy": camera.get("cy", config.height / 2)}
    for name, value in numbers.items():
        try:
            numbers[name] = float(value)
        except (TypeError, ValueError):
            raise TypeError(f"camera {name}: {value!r}; a number is needed"
                            ) from None
    world = _matrix("camera view_to_world",
                    camera.get("view_to_world", np.eye(4)))
    if camera.get("opengl"):
        lib.hbil_camera_from_opengl(to, world, *numbers.values())
    else:
        for name, value in numbers.items():
            setattr(to, name, value)
        to.world_from_view = list(world)
    if "hardware_depth" in camera:
        frame.hardware_depth = numbers_of("camera hardware_depth",
                                          camera["hardware_depth"], 2)


def set_environment(frame: Any, config: Any, environment: Any) -> None:
    """Fills environment of an hbil_frame, and says which far field that is."""
    try:
        values = np.ascontiguousarray(environment, np.float32)
    except (TypeError, ValueError):
        raise TypeError("environment: numbers are needed") from None
    if values.shape == (3,):
        frame.environment[0] = values.tolist()
        config.model.far_field = lib.HBIL_FAR_CONSTANT
    elif values.shape == (9, 3):
        frame.environment = values.tolist()
        config.model.far_field = lib.HBIL_FAR_SH
    elif values.ndim == 3 and values.shape[2] == 3:
        check(lib.hbil_environment_from_latlong(
            ffi.from_buffer("float[]", values), values.shape[1],
            values.shape[0], 0, ffi.NULL, frame.environment))
        config.model.far_field = lib.HBIL_FAR_SH
    else:
        raise ValueError(f"environment: shape {values.shape}; (3,), (9, 3) or "
                         "(height, width, 3) is needed")

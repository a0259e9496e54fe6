"""Frames: a single one, and sequences with a radiance cache."""
from __future__ import annotations

import functools
import threading
import warnings
from dataclasses import dataclass
from typing import (Any, Callable, Dict, Iterable, List, Mapping, Optional,
                    Sequence as Items, Tuple, TypeVar, Union, cast)

import numpy as np

from . import _checks, _extent
from ._arrays import (COLOURS, INPUTS, LAYERS, Plane, convert, host_plane, input_plane,
                      is_on_device, values)
from ._library import check, cl, check_opencl, ffi, lib
from ._opencl import (Device, device_of_queue, enqueue, enqueue_for_event,
                      check_device, check_queue, handle, open_device, read,
                      write)
from ._settings import (apply, check_names, choice, names_of, new_config, number,
                        numbers_of, set_camera, set_environment)

Array = Any  # numpy.ndarray, what numpy.asarray() takes, or pyopencl's Array
Camera = Mapping[str, Any]

# Plans that process() has of each device at most: they hold device memory.
_PLANS_MOST = 2


@dataclass
class View:
    """A picture that shows a radiance cache a part of the place.

    The planes are those of process(), of any size.  light: "direct", or
    "finished" if `direct` is the radiance (W/(m2 sr)) that surfaces send after
    all bounces, emission included.
    """
    depth: Array
    normal: Optional[Array]
    albedo: Optional[Array]
    direct: Optional[Array]
    camera: Camera
    f0: Optional[Array] = None
    emission: Optional[Array] = None
    light: str = "direct"

    def planes(self) -> Dict[str, Array]:
        return {name: getattr(self, name) for name in INPUTS
                if getattr(self, name, None) is not None}


def _views_of(name: str, value: Iterable[View]) -> List[View]:
    if not isinstance(value, Iterable):
        raise TypeError(f"{name}: {type(value).__name__}; a list of hbil.View is "
                        "needed")
    views = list(value)
    for index, view in enumerate(views):
        if not isinstance(view, View):
            raise TypeError(f"{name}[{index}]: {type(view).__name__}; an "
                            "hbil.View is needed")
    return views


def _default_layers(mode: int) -> List[str]:
    """All that cost next to nothing, as far as the mode has them."""
    absent = {"error_estimate", "unknown", "glossy"}
    if mode != lib.HBIL_MODE_HBIL:
        absent.add("near_irradiance")
    if mode == lib.HBIL_MODE_HBAO:
        absent |= {"bent_normal", "cone_cosine"}
    return [name for name in LAYERS if name not in absent]


class _Settings:
    """What process() and Sequence are asked for, beside the frames."""

    def __init__(self, options: Dict[str, Any], layers: Optional[Items[str]],
                 dtype: Any, device: Union[None, int, str], queue: Any,
                 environment: Any, sky_share: Optional[float],
                 srgb: Items[str], warm_up: int) -> None:
        check_names(options)
        self.options = options
        self.layers = layers if layers is None else names_of("layers", layers,
                                                             LAYERS)
        if self.layers == []:
            raise ValueError("layers: at least one is needed")
        try:
            self.dtype = np.dtype(dtype)
        except TypeError:
            raise TypeError(f"dtype: {dtype!r}; float32 or float16 is needed"
                            ) from None
        if self.dtype not in (np.float32, np.float16):
            raise TypeError(f"dtype: {self.dtype}; float32 or float16 is needed")
        self.device, self.queue = check_device(device), check_queue(queue)
        self.environment = environment
        self.sky_share = sky_share if sky_share is None else number("sky_share",
                                                                    sky_share)
        self.srgb = names_of("srgb", srgb, COLOURS)
        self.warm_up = number("warm_up", warm_up, "cl_uint")
        probe = new_config()  # says early what is wrong
        apply(probe, options)
        self.hardware = probe.inputs.depth_kind == lib.HBIL_DEPTH_HARDWARE
        self.octahedral = (probe.inputs.normal_encoding
                           == lib.HBIL_NORMAL_OCTAHEDRAL)

    def collect(self, given: Mapping[str, Array],
                title: str = "") -> Tuple[Dict[str, Plane], Tuple[int, int]]:
        """The planes of a frame or view, and its height and width."""
        size = None
        planes = {}
        for name in INPUTS:
            if given.get(name) is None:
                if name == "depth":
                    raise TypeError(f"{title}depth: an array is needed")
                continue
            planes[name] = input_plane(name, given[name], size, self.hardware,
                                       self.octahedral, name in self.srgb,
                                       title + name)
            if size is None:
                size = tuple(given[name].shape[:2]) if is_on_device(
                    given[name]) else planes[name].array.shape[:2]
        return planes, size

    def open(self, planes: Mapping[str, Plane]) -> Tuple[Device, Any, Any]:
        """Device, queue and, if results stay on the device, pyopencl's queue."""
        queue = self.queue
        if queue is None:
            queue = next((plane.array.queue for plane in planes.values()
                          if plane.on_device and plane.array.queue is not None),
                         None)
        if queue is not None:
            return device_of_queue(queue), handle("cl_command_queue",
                                                  queue), queue
        device = open_device(self.device)
        return device, device.queue(bool(self.options.get("profiling"))), None

    def configure(self, planes: Mapping[str, Plane],
                  size: Tuple[int, int]) -> Any:
        config = new_config()
        config.height, config.width = size
        apply(config, self.options)
        if "bent_normal_space" not in self.options:
            config.outputs.bent_normal_space = config.inputs.normal_space
        for name, plane in planes.items():
            setattr(config.inputs, name, plane.format)
        layers = self.layers or _default_layers(config.model.mode)
        component = (lib.HBIL_FLOAT16 if self.dtype == np.float16
                     else lib.HBIL_FLOAT32)
        for name in layers:
            setattr(config.outputs, name,
                    (component, LAYERS[name] * self.dtype.itemsize))
        return config

    def frame(self, config: Any, camera: Camera) -> Any:
        frame = ffi.new("hbil_frame *")
        lib.hbil_frame_init_sized(frame, ffi.sizeof("hbil_frame"))
        set_camera(frame, camera, config)
        return frame

    def decide(self, planes: Mapping[str, Plane], config: Any, frame: Any,
               views: Items[Tuple[Any, Any, Any]] = ()) -> None:
        """What the pixels of views and a first frame decide, or the caller
        does.  views: planes, frame and configuration of each."""
        if self.environment is not None:
            set_environment(frame, config, self.environment)
            apply(config, {name: value for name, value in self.options.items()
                           if name == "far_field"})
        far_is_open = (config.model.far_field == lib.HBIL_FAR_AUTO)
        emission_is_open = "gather_emission" not in self.options
        if (far_is_open or emission_is_open) and \
                not any(plane.on_device for plane in planes.values()):
            found = ffi.new("hbil_sources *")
            for shown, camera, how in views:
                if not any(plane.on_device for plane in shown.values()):
                    self._suggest(shown, how, camera, found)
            chosen, lit = self._suggest(planes, config, frame, found)
            if far_is_open:
                config.model.far_field = chosen.model.far_field
                frame.environment = lit.environment
                frame.sky_share = lit.sky_share
            if emission_is_open:
                config.model.gather_emission = chosen.model.gather_emission
        if self.sky_share is not None:
            frame.sky_share = self.sky_share

    def _suggest(self, planes: Mapping[str, Plane], config: Any, frame: Any,
                 found: Any) -> Tuple[Any, Any]:
        """Copies of the configuration and the frame, with what the library
        suggests by this picture and those that it has found before."""
        host = ffi.new("hbil_host_planes *")
        held = []  # until the call is over
        for name, field in ffi.typeof("hbil_host_planes").fields:
            if name not in planes or (name == "normal" and self.octahedral) or (
                    name == "albedo" and not config.inputs.direct_kind):
                continue
            floats = values(name, planes[name])
            held.append(floats)
            starts, pitch = host_plane(floats, planes[name].planar)
            to = getattr(host, name)
            for channel, address in enumerate(starts):
                to.channel[channel] = ffi.cast("float *", address)
            to.pixel_pitch = pitch
        chosen, lit = ffi.new("hbil_config *", config[0]), ffi.new(
            "hbil_frame *", frame[0])
        check(lib.hbil_config_suggest(host, chosen, lit, found))
        return chosen, lit


class _Plan:
    """A plan, and buffers for planes in host memory."""

    def __init__(self, device: Device, config: Any, dtype: np.dtype) -> None:
        self.device, self.config, self.dtype = device, config, dtype
        self.size = (config.height, config.width)
        self.layers = [name for name in LAYERS
                       if getattr(config.outputs, name).component]
        out = ffi.new("hbil_plan **")
        device.check(lib.hbil_plan_create(device.context, config, out))
        self.plan = device.owned(out[0], lib.hbil_plan_destroy)
        self.buffers: Dict[str, Any] = {}
        self.index = 0
        self.last: Optional[Any] = None  # the event of the last frame

    def shape(self, layer: str) -> Tuple[int, ...]:
        return self.size if LAYERS[layer] == 1 else self.size + (LAYERS[layer],)

    def _buffer(self, name: str, size: int, writable: bool) -> Any:
        if name not in self.buffers:
            self.buffers[name] = self.device.buffer(size, writable)
        return self.buffers[name]

    def place(self, frame: Any, queue: Any, planes: Mapping[str, Plane],
              blocking: bool) -> List[Any]:
        """Puts inputs into a frame; the events that it must wait for."""
        waits = []
        for name, plane in planes.items():
            to = getattr(frame, name)
            if plane.on_device:
                put_device_plane(to, plane)
                waits += [handle("cl_event", e) for e in plane.array.events]
                continue
            to.buffer = self._buffer(name, plane.array.nbytes, False)
            waits += write(queue, to.buffer, plane.array, blocking,
                           [self.last] if self.last is not None else [])
        return waits

    def _no_motion(self, frame: Any, queue: Any) -> None:
        """Nothing moves between two runs of the same frame."""
        pitch = self.config.inputs.motion.pixel_pitch
        if not pitch:
            return
        # enough for two planes, and for two channels in one
        zeros = np.zeros(self.size[0] * self.size[1] * 2 * pitch, np.uint8)
        to = frame.motion
        to.offset = to.row_pitch = to.plane_pitch = 0
        fresh = "no motion" not in self.buffers
        to.buffer = self._buffer("no motion", zeros.nbytes, False)
        if fresh:
            write(queue, to.buffer, zeros, True)

    def outputs(self, frame: Any, pyopencl_queue: Any,
                out: Optional[Mapping[str, Array]]) -> Dict[str, Array]:
        """Makes results, or takes the caller's, and puts them into a frame."""
        results = {}
        out = {} if out is None else out
        if not isinstance(out, Mapping):
            raise TypeError(f"out: {type(out).__name__}; a dict of arrays is "
                            "needed")
        for name in out:
            if name not in self.layers:
                raise ValueError(f"out: {name!r} is none of the layers "
                                 f"{', '.join(self.layers)}")
        for name in self.layers:
            array = out.get(name)
            if array is None:
                array = _empty(self.shape(name), self.dtype, pyopencl_queue)
            elif not is_on_device(array) and not isinstance(array, np.ndarray):
                raise TypeError(f"out {name}: {type(array).__name__}; an array "
                                "is needed")
            elif tuple(array.shape) != self.shape(name) or \
                    array.dtype != self.dtype:
                raise ValueError(f"out {name}: {array.dtype} of shape "
                                 f"{tuple(array.shape)}; {self.dtype} of "
                                 f"{self.shape(name)} is needed")
            elif not array.flags.c_contiguous:
                raise ValueError(f"out {name}: not contiguous")
            results[name] = array
            to = getattr(frame, name)
            if is_on_device(array):
                to.buffer = handle("cl_mem", array.base_data)
                to.offset = array.offset
            else:
                to.buffer = self._buffer(name, array.nbytes, True)
        return results

    def run(self, frame: Any, queue: Any, waits: List[Any], runs: int,
            static: bool) -> None:
        """Lights a frame; `last` becomes the event of its last run."""
        for run in range(runs):
            if run == 1:
                self._no_motion(frame, queue)
            frame.static_frame = static or run > 0
            if run + 1 < runs:
                enqueue(self.device, lib.hbil_enqueue_frame, self.plan, queue,
                        frame, after=waits)
        self.last = enqueue_for_event(self.device, lib.hbil_enqueue_frame,
                                      self.plan, queue, frame, after=waits)

    def sanitized(self, queue: Any) -> Dict[str, int]:
        """The members of hbil_sanitized, of the last frame."""
        found = ffi.new("hbil_sanitized *")
        self.device.check(lib.hbil_plan_sanitized(self.plan, queue, found))
        return {name: getattr(found, name)
                for name, _ in ffi.typeof("hbil_sanitized").fields}

    def take(self, frame: Any, queue: Any, results: Mapping[str, Array]) -> None:
        """Reads those results that are numpy's, and tells pyopencl's others
        what to wait for."""
        for name, array in results.items():
            if is_on_device(array):
                import pyopencl
                array.add_event(pyopencl.Event.from_int_ptr(
                    int(ffi.cast("uintptr_t", self.last)), retain=True))
            else:
                read(queue, getattr(frame, name).buffer, array, self.last)


def put_device_plane(to: Any, plane: Plane) -> None:
    to.buffer = handle("cl_mem", plane.array.base_data)
    to.offset, to.row_pitch = plane.offset, plane.row_pitch
    to.plane_pitch = plane.plane_pitch


def _empty(shape: Tuple[int, ...], dtype: np.dtype, queue: Any) -> Array:
    if queue is None:
        return np.empty(shape, dtype)
    import pyopencl.array
    return pyopencl.array.empty(queue, shape, dtype)


def _warn(found: List[str], callers: int) -> None:
    """One warning for all, to the code that calls the package."""
    if found:
        warnings.warn("; ".join(found), stacklevel=callers)


def _finish(queue: Any) -> None:
    """The device may still use arrays that are about to go."""
    cl.clFinish(queue)


def _plan_of(device: Device, config: Any, dtype: np.dtype) -> _Plan:
    """A plan of process(), which has those that were used last."""
    key = bytes(ffi.buffer(config))
    plan = device.plans.pop(key, None)
    while len(device.plans) >= _PLANS_MOST:
        device.plans.popitem(last=False)
    if plan is None:
        plan = _Plan(device, config, dtype)
    device.plans[key] = plan
    return plan


def process(depth: Array, normal: Optional[Array], albedo: Optional[Array],
            direct: Optional[Array], camera: Camera, *,
            f0: Optional[Array] = None, emission: Optional[Array] = None,
            layers: Optional[Items[str]] = None, dtype: Any = np.float32,
            environment: Any = None, sky_share: Optional[float] = None,
            srgb: Items[str] = (), warm_up: int = 3,
            device: Union[None, int, str] = None, queue: Any = None,
            out: Optional[Mapping[str, Array]] = None,
            **options: Any) -> Dict[str, Array]:
    """Lights one picture.

    The inputs are arrays of (height, width) or (height, width, channels), of
    any contiguity; planes of (channels, height, width) are
    numpy.moveaxis(planes, 0, -1), which copies nothing.  Floats of any
    precision are values; float32 and float16 are read as they are, depth and
    normals of float16 with room for their rounding.  Of colours and normals,
    uint8 and uint16 (of normals int8 and int16, too) are the formats UNORM and
    SNORM of hbil_formats.h: 0..255 stands for 0..1.  Other integers are values.

    depth     (height, width): z, in world units, or what depth_kind says
    normal    (height, width, 3): in view space, or in the world's with
              normal_space="world"; None: rebuilt from depth
    albedo    (height, width, 3), (3,) or a number: diffuse reflectance, 0..1;
              None: 1
    direct    (height, width, 3), (3,) or a number: irradiance, W/m2
    camera    a dict.  Either fx, fy, cx, cy: focal lengths and principal point
              in pixels from the top left corner (fy: default fx; cx, cy: the
              middle), and optionally view_to_world, 4 x 4, row-major for column
              vectors (default: the identity); with opengl=True, that of OpenGL
              and Blender, where y is up and z backward.  Or projection and
              view (world to view space), 4 x 4, and optionally conventions, a
              list of "column_major", "signed_depth", "reversed_depth",
              "y_down" (hbil_camera_from_matrices())
    f0        (height, width, 3): reflectance at normal incidence
    emission  (height, width, 3): radiance, W/(m2 sr); at the sky, the sky's
    layers    names of results (hbil.LAYERS); default: those of hbil process
    dtype     of the results: float32 or float16
    environment  radiance from outside the picture: (3,) from everywhere, (9, 3)
              spherical harmonics, or (height, width, 3) a latitude-longitude
              map with z up.  None: the picture decides
              (hbil_config_suggest()), but with arrays on the device
    sky_share hbil_frame.sky_share, with far_field="frame"
    srgb      names of uint8 colours with the curve of sRGB, as ("albedo",)
    warm_up   how often the picture is lit once more, each time with one more
              bounce of light
    device    an index or a part of a name of hbil.devices(); default: the first
              GPU, else the first device
    queue     pyopencl's CommandQueue: results are then pyopencl's arrays, and
              the call doesn't wait for them.  Inputs may be pyopencl's arrays,
              which are not copied
    out       arrays for some results, by their names: numpy's or pyopencl's
    options   members of hbil_config (hbil.options() has them, with defaults),
              with words for enums: quality="fast", radius=2.0, mode="gtao";
              two words are those of hbil process alone: direct_kind="light",
              for E / pi, and normal_space="camera", for y up and z backward

    Returns a dict of arrays by the layers' names, (height, width) or (height,
    width, channels): near_irradiance, far_irradiance (W/m2), indirect, beauty
    (W/(m2 sr)), ao (0 closed .. 1 open), bent_normal (in the world, if the
    normals are, else in view space), cone_cosine.  The first call for a size and options builds
    kernels, which takes seconds.  What arrays of numpy show to be wrong is a
    warning: normals that don't fit the depth, and values that mean nothing, as
    NaN.  Any thread may call it; calls for one device
    wait for each other.
    """
    settings = _Settings(options, layers, dtype, device, queue, environment,
                         sky_share, srgb, warm_up)
    planes, size = settings.collect(
        {"depth": depth, "normal": normal, "albedo": albedo, "direct": direct,
         "f0": f0, "emission": emission})
    on, cl_queue, pyopencl_queue = settings.open(planes)
    config = settings.configure(planes, size)
    frame = settings.frame(config, camera)
    settings.decide(planes, config, frame)
    found = _checks.fit_of_normals((planes, frame, config), camera)
    with on.lock:
        plan = _plan_of(on, config, settings.dtype)
        lib.hbil_plan_reset(plan.plan)
        try:
            results = plan.outputs(frame, pyopencl_queue, out)
            waits = plan.place(frame, cl_queue, planes,
                               pyopencl_queue is not None)
            plan.run(frame, cl_queue, waits, 1 + settings.warm_up, False)
            plan.take(frame, cl_queue, results)
            if pyopencl_queue is None:  # else the device may not be ready yet
                found += _checks.replaced(plan.sanitized(cl_queue))
        except BaseException:
            _finish(cl_queue)
            raise
    _warn(found, 3)
    return results


_Method = TypeVar("_Method", bound=Callable[..., Any])


def _alone(method: _Method) -> _Method:
    """A method of a Sequence for which those that other threads call wait."""
    @functools.wraps(method)
    def call(self: Any, *arguments: Any, **named: Any) -> Any:
        with self._lock:
            return method(self, *arguments, **named)
    return cast(_Method, call)


class Sequence:
    """Frames of a sequence, in order: light bounces once more in each, and a
    radiance cache knows what earlier frames and views have shown.

        with hbil.Sequence(views=views) as sequence:
            for frame in frames:
                layers = sequence.process(*frame)

    cache    True: a radiance cache whose middle and size the first frame and
             the views decide; False: none; or a dict of members of
             hbil_cache_config: voxel_size (world units), centre, voxels,
             levels, unseen_light; or what save_cache() has returned
    views    hbil.View, which the cache sees before the first frame: of all the
             place, if possible, some later frames among them, since the cache
             becomes no larger than the first frame and the views show
    light_views  views from lights, with cache_method="rsm" (hbil_cache.h)
    learn    False: frames don't change the cache

    All else is as in process(); the first frame decides what is left open, and
    it and the views are looked at for warnings: sanitized() tells of others.
    Kernels are built at the first frame.  Any thread may call the methods: a
    call waits for those of other threads, close() for their frame, too.  But
    whoever lights frames in several threads must see to their order.
    """

    def __init__(self, *, cache: Union[bool, Mapping[str, Any]] = True,
                 views: Iterable[View] = (), light_views: Iterable[View] = (),
                 learn: bool = True, layers: Optional[Items[str]] = None,
                 dtype: Any = np.float32, environment: Any = None,
                 sky_share: Optional[float] = None, srgb: Items[str] = (),
                 warm_up: int = 3, device: Union[None, int, str] = None,
                 queue: Any = None, **options: Any) -> None:
        self._lock = threading.RLock()
        self._settings = _Settings(options, layers, dtype, device, queue,
                                   environment, sky_share, srgb, warm_up)
        if not isinstance(cache, (bool, Mapping)):
            raise TypeError(f"cache: {type(cache).__name__}; True, False or a "
                            "dict is needed")
        # a file of numpy.load() may be closed before the first frame
        self._wanted = cache if isinstance(cache, bool) else dict(cache)
        self._learn = learn
        self._views = _views_of("views", views)
        self._light_views = _views_of("light_views", light_views)
        self._plan: Optional[_Plan] = None  # of the last frame
        self._other: Optional[_Plan] = None  # of another size, before that
        self._cache: Any = None
        self._first: Any = None  # the frame that decided

    def __enter__(self) -> "Sequence":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    @_alone
    def close(self) -> None:
        """Releases device memory; the next frame is then a first one."""
        self._plan = self._other = self._cache = self._first = None

    def _open(self, planes: Mapping[str, Plane], size: Tuple[int, int],
              camera: Camera) -> None:
        settings = self._settings
        if self._wanted is not False and "normal" not in planes:
            raise TypeError("normal: an array is needed, because a radiance "
                            "cache has no other normals; or cache=False")
        self._device, self._queue, self._pyopencl_queue = settings.open(planes)
        config = settings.configure(planes, size)
        self._first = settings.frame(config, camera)
        views = [self._view_picture(view, f"views[{index}] ")
                 for index, view in enumerate(self._views)]
        settings.decide(planes, config, self._first, views)
        self._found = _checks.fit_of_normals((planes, self._first, config),
                                             camera)
        for index, view in enumerate(self._views):
            self._found += [f"views[{index}] {found}" for found in
                            _checks.fit_of_normals(views[index], view.camera)]
        self._inputs = dict(planes)
        cache_config = None
        if self._wanted is not False:
            cache_config = self._configure_cache(
                config, [(planes, self._first, config)] + views)
        with self._device.lock:
            if cache_config is not None:
                self._create_cache(cache_config)
            plan = _Plan(self._device, config, settings.dtype)
            self._plan = plan
            if cache_config is not None:
                self._see_views(self._views)

    # --- the radiance cache ---

    def _configure_cache(self, config: Any,
                         pictures: List[Tuple[Any, Any, Any]]) -> Any:
        wanted = {} if self._wanted is True else dict(self._wanted)
        self._saved = wanted.pop("bytes", None)
        if self._saved is not None:
            try:
                self._saved = np.frombuffer(self._saved, np.uint8)
            except (TypeError, ValueError, BufferError):
                raise TypeError(
                    f"cache bytes: {type(self._saved).__name__}; those that "
                    "save_cache() has returned are needed") from None
        cache = ffi.new("hbil_cache_config *")
        lib.hbil_cache_config_init_sized(cache, ffi.sizeof("hbil_cache_config"))
        known = [name for name, field in ffi.typeof("hbil_cache_config").fields
                 if name not in ("struct_size", "inputs", "method")]
        for name, value in wanted.items():
            if name not in known:
                raise ValueError(f"cache: {name!r}; of {', '.join(known)} are "
                                 "needed")
            try:
                setattr(cache, name, numbers_of(name, value, 3)
                        if name == "centre" else value)
            except (TypeError, ValueError, OverflowError, IndexError):
                raise TypeError(f"cache {name}: {value!r} is no such value"
                                ) from None
        method = self._settings.options.get("cache_method", "rays")
        cache.method = choice("cache_method", method, "hbil_cache_method")
        if "voxel_size" not in wanted:
            _extent.choose(cache, pictures, "centre" not in wanted)
        check(lib.hbil_config_use_cache(config, cache))
        apply(config, {name: value for name, value in
                       self._settings.options.items()
                       if name in ("radius", "near_relative_thickness")})
        return cache

    def _view_picture(self, view: View, title: str) -> Tuple[Any, Any, Any]:
        planes, size = self._settings.collect(view.planes(), title)
        config = new_config()
        apply(config, self._settings.options)
        config.height, config.width = size
        return planes, self._settings.frame(config, view.camera), config

    def _create_cache(self, config: Any) -> None:
        out = ffi.new("hbil_cache **")
        self._device.check(lib.hbil_cache_create(self._device.context, config,
                                                 out))
        self._cache = self._device.owned(out[0], lib.hbil_cache_destroy)
        self._cache_config = config
        if self._saved is not None:
            self._device.check(lib.hbil_cache_load(
                self._cache, self._queue, ffi.from_buffer(self._saved),
                len(self._saved)))

    def _prepare_view(self, view: View, title: str) -> Tuple[Any, List[Any]]:
        """An hbil_view, whose planes are in buffers that are returned, too."""
        planes, frame, config = self._view_picture(view, title)
        out = ffi.new("hbil_view *")
        check(lib.hbil_view_from_frame_sized(out, ffi.sizeof("hbil_view"),
                                             config, frame))
        out.light = choice("light", view.light, "hbil_view_light")
        for name in planes:
            if name not in self._inputs:
                raise ValueError(f"{title}{name}: frames have none")
        held = []
        for name, like in self._inputs.items():
            if name == "motion":
                continue
            to = getattr(out, name)
            plane = planes.get(name)
            if plane is None:  # as frames without such a plane are
                missing = np.float32(1 if name == "albedo" else 0)
                if name in ("depth", "normal"):
                    raise TypeError(f"{title}{name}: an array is needed")
                plane = input_plane(name, missing, (config.height, config.width))
            if plane.on_device:
                if plane.format != like.format:
                    raise TypeError(f"{title}{name}: another format than that of "
                                    "frames")
                put_device_plane(to, plane)
                held.append(plane.array)
                for event in plane.array.events:
                    event.wait()
                continue
            plane = convert(name, plane, like, title + name)
            held.append(self._device.buffer(plane.array.nbytes, False))
            to.buffer = held[-1]
            write(self._queue, to.buffer, plane.array, True)
        return out, held

    def _see_views(self, views: List[View]) -> None:
        held = []
        for index, view in enumerate(views):
            prepared, buffers = self._prepare_view(view, f"views[{index}] ")
            held.append(buffers)
            enqueue(self._device, lib.hbil_enqueue_cache_inject, self._cache,
                    self._queue, prepared, 1)
        if self._light_views:
            array = ffi.new("hbil_view[]", len(self._light_views))
            for index, view in enumerate(self._light_views):
                prepared, buffers = self._prepare_view(
                    view, f"light_views[{index}] ")
                held.append(buffers)
                array[index] = prepared[0]
            enqueue(self._device, lib.hbil_enqueue_cache_light_views,
                    self._cache, self._queue, array, len(array))
        # "Some 16 should follow a first injection" (hbil_cache.h)
        self._update(16 if views and self._saved is None else 0)
        check_opencl(cl.clFinish(self._queue), "showing views to the cache")

    def _update(self, bounces: Optional[int] = None) -> None:
        how = ffi.new("hbil_cache_update *")
        lib.hbil_cache_update_init_sized(how, ffi.sizeof("hbil_cache_update"))
        if bounces is not None:
            how.bounces = bounces
        how.far_field = self._plan.config.model.far_field
        how.environment = self._first.environment
        enqueue(self._device, lib.hbil_enqueue_cache_update, self._cache,
                self._queue, how)

    def _see_frame(self, plan: _Plan, frame: Any, waits: List[Any]) -> None:
        if self._learn:
            view = ffi.new("hbil_view *")
            check(lib.hbil_view_from_frame_sized(
                view, ffi.sizeof("hbil_view"), plan.config, frame))
            enqueue(self._device, lib.hbil_enqueue_cache_inject, self._cache,
                    self._queue, view, 1, after=waits)
            self._update()
        frame.cache = self._cache

    def _need_cache(self) -> None:
        if self._cache is None:
            raise ValueError("there is no radiance cache (yet: the first frame "
                             "makes it)")

    @_alone
    def add_views(self, views: Iterable[View]) -> None:
        """Shows the cache more views; before the first frame, too."""
        views = _views_of("views", views)
        if self._plan is None:
            self._views += views
            return
        self._need_cache()
        with self._device.lock:
            self._saved = None
            self._see_views(views)
        self._views += views

    @_alone
    def move_cache(self, centre: Items[float]) -> None:
        """Moves the cache's middle; what stays inside stays known."""
        self._need_cache()
        with self._device.lock:
            enqueue(self._device, lib.hbil_enqueue_cache_move, self._cache,
                    self._queue, ffi.new("double[3]",
                                         numbers_of("centre", centre, 3)))

    @_alone
    def forget_in_cache(self, *, surfaces: float = 0.0, light: float = 0.0,
                        low: Optional[Items[float]] = None,
                        high: Optional[Items[float]] = None) -> None:
        """Forgets shares, 0..1, of what is known of surfaces and of their
        light, in a box of the world or everywhere: what has changed where no
        frame shows it.  The next frame sees it."""
        self._need_cache()
        change = ffi.new("hbil_cache_change *")
        lib.hbil_cache_change_init_sized(change,
                                         ffi.sizeof("hbil_cache_change"))
        if low is not None:
            change.low = numbers_of("low", low, 3)
        if high is not None:
            change.high = numbers_of("high", high, 3)
        change.surfaces = number("surfaces", surfaces)
        change.light = number("light", light)
        with self._device.lock:
            enqueue(self._device, lib.hbil_enqueue_cache_forget, self._cache,
                    self._queue, change)
            if not self._learn:  # else the next frame's view is followed by one
                self._update()

    @_alone
    def reset_cache(self) -> None:
        """Forgets everything that the cache has seen."""
        self._need_cache()
        with self._device.lock:
            enqueue(self._device, lib.hbil_enqueue_cache_reset, self._cache,
                    self._queue)

    @_alone
    def save_cache(self) -> Dict[str, Any]:
        """All that the cache knows, as a dict of numbers and an array, which
        pickle and numpy.savez(path, **saved) store; the argument `cache` of a
        Sequence, as numpy.load(path) is, too."""
        self._need_cache()
        with self._device.lock:
            data = np.empty(lib.hbil_cache_size(self._cache), np.uint8)
            self._device.check(lib.hbil_cache_save(
                self._cache, self._queue,
                ffi.from_buffer(data, require_writable=True), len(data)))
        config = self._cache_config
        return {"voxels": config.voxels, "levels": config.levels,
                "voxel_size": config.voxel_size,
                "centre": tuple(config.centre), "bytes": data}

    # --- frames ---

    @_alone
    def process(self, depth: Array, normal: Optional[Array],
                albedo: Optional[Array], direct: Optional[Array],
                camera: Camera, *, f0: Optional[Array] = None,
                emission: Optional[Array] = None,
                motion: Optional[Array] = None, static: bool = False,
                out: Optional[Mapping[str, Array]] = None) -> Dict[str, Array]:
        """Lights the next frame; all arguments and results are as in
        hbil.process().

        All frames have the same planes, of the same types.  Their size may
        change: light goes on from the last frame's (hbil_plan_follow()).
        Kernels are built for each size; those of the last two stay.
        motion    (height, width, 2): the previous position minus the current
                  one, in pixels; for reprojection="motion"
        static    nothing has moved since the last frame
        """
        settings = self._settings
        planes, size = settings.collect(
            {"depth": depth, "normal": normal, "albedo": albedo,
             "direct": direct, "f0": f0, "emission": emission,
             "motion": motion})
        first = self._plan is None
        if first:
            try:
                self._open(planes, size, camera)
            except BaseException:
                self.close()
                raise
        self._check_planes(planes)
        plan = self._plan_of_size(size)
        frame = settings.frame(plan.config, camera)
        frame.environment = self._first.environment
        frame.sky_share = self._first.sky_share
        with self._device.lock:
            try:
                results = plan.outputs(frame, self._pyopencl_queue, out)
                waits = plan.place(frame, self._queue, planes,
                                   self._pyopencl_queue is not None)
                if self._cache is not None:
                    self._see_frame(plan, frame, waits)
                plan.run(frame, self._queue, waits,
                         1 + settings.warm_up if first else 1,
                         bool(static) and not first)
                if plan is not self._plan:
                    self._plan, self._other = plan, self._plan
                plan.take(frame, self._queue, results)
                if first and self._pyopencl_queue is None:
                    self._found += _checks.replaced(plan.sanitized(self._queue))
            except BaseException:
                _finish(self._queue)
                if first:
                    self.close()
                raise
        if first:
            _warn(self._found, 4)  # the method is wrapped
        return results

    def _plan_of_size(self, size: Tuple[int, int]) -> _Plan:
        """The plan of the last frame or, for another size, one that follows
        it."""
        last, plan = self._plan, self._other
        if size == last.size:
            return last
        with self._device.lock:
            if plan is None or plan.size != size:
                self._other = None  # its memory may be needed
                config = ffi.new("hbil_config *", last.config[0])
                config.height, config.width = size
                plan = self._other = _Plan(self._device, config, last.dtype)
            self._device.check(lib.hbil_plan_follow(plan.plan, last.plan))
        return plan

    def _check_planes(self, planes: Dict[str, Plane]) -> None:
        for name in INPUTS:
            if (name in planes) != (name in self._inputs):
                raise ValueError(f"{name}: all frames need it or none")
        for name, like in self._inputs.items():
            if planes[name].on_device:
                if planes[name].format != like.format:
                    raise TypeError(f"{name}: another format than in the first "
                                    "frame")
            else:
                planes[name] = convert(name, planes[name], like, name)

    @_alone
    def reset(self) -> None:
        """Forgets the history: the next frame is as at a cut.  The radiance
        cache stays."""
        if self._plan is not None:
            with self._device.lock:
                lib.hbil_plan_reset(self._plan.plan)

    @_alone
    def sanitized(self) -> Dict[str, int]:
        """How many pixels of each input of the last frame were unusable
        (hbil_sanitized)."""
        if self._plan is None:
            raise ValueError("there was no frame yet")
        with self._device.lock:
            return self._plan.sanitized(self._queue)

    @_alone
    def timings(self) -> Dict[str, float]:
        """Milliseconds of each pass of the last frame; with profiling=True."""
        if self._plan is None:
            raise ValueError("there was no frame yet")
        found = ffi.new("double[]", lib.HBIL_PASS_COUNT)
        with self._device.lock:
            self._device.check(lib.hbil_plan_timings(self._plan.plan, found))
        return {ffi.string(lib.hbil_pass_name(index)).decode(): found[index]
                for index in range(lib.HBIL_PASS_COUNT)}

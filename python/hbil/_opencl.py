"""Devices, queues and buffers of OpenCL, with and without pyopencl."""
from __future__ import annotations

import operator
import os
import sys
import threading
from collections import OrderedDict
from typing import Any, Callable, Iterable, List, Union

import numpy as np

from ._library import (Error, check, check_opencl, check_process, cl, ffi, lib,
                       owned, text)


def _platform_devices(platform: Any) -> List[Any]:
    count = ffi.new("cl_uint *")
    if cl.clGetDeviceIDs(platform, cl.CL_DEVICE_TYPE_ALL, 0, ffi.NULL, count):
        return []
    ids = ffi.new("cl_device_id[]", count[0])
    check_opencl(cl.clGetDeviceIDs(platform, cl.CL_DEVICE_TYPE_ALL, count[0],
                                   ids, ffi.NULL), "listing devices")
    return list(ids)


def _all_devices() -> List[Any]:
    check_process()
    count = ffi.new("cl_uint *")
    if cl.clGetPlatformIDs(0, ffi.NULL, count) or not count[0]:
        return []
    platforms = ffi.new("cl_platform_id[]", count[0])
    check_opencl(cl.clGetPlatformIDs(count[0], platforms, ffi.NULL),
                 "listing platforms")
    return [device for platform in platforms
            for device in _platform_devices(platform)]


def _device_info(device: Any, what: int, kind: str) -> Any:
    value = ffi.new(kind)
    check_opencl(cl.clGetDeviceInfo(device, what, ffi.sizeof(value) if
                                    kind.endswith("]") else
                                    ffi.sizeof(ffi.typeof(value).item), value,
                                    ffi.NULL), "asking a device")
    return value


def _name(device: Any) -> str:
    return text(_device_info(device, cl.CL_DEVICE_NAME, "char[1024]"))


def devices() -> List[str]:
    """Names of the machine's OpenCL devices, in OpenCL's order."""
    return [_name(device) for device in _all_devices()]


def _choose(wanted: Union[None, int, str]) -> Any:
    """An index or a part of a name; None: the first GPU, else the first."""
    found = _all_devices()
    if not found:
        raise Error("no OpenCL device; a driver is needed, for example Debian's "
                    "pocl-opencl-icd", "OPENCL")
    if wanted is None:
        for device in found:
            if (_device_info(device, cl.CL_DEVICE_TYPE, "cl_device_type *")[0]
                    & cl.CL_DEVICE_TYPE_GPU):
                return device
        return found[0]
    for index, device in enumerate(found):
        if index == wanted if isinstance(wanted, int) else \
                wanted.lower() in _name(device).lower():
            return device
    raise ValueError(f"device: {wanted!r} is not there; an index or a part of a "
                     "name of hbil.devices() is needed")


def check_device(wanted: Any) -> Union[None, int, str]:
    """The argument `device`, if it can be one."""
    if wanted is None or isinstance(wanted, str):
        return wanted
    try:
        return operator.index(wanted)
    except TypeError:
        raise TypeError(f"device: {wanted!r}; an index or a part of a name of "
                        "hbil.devices() is needed") from None


def check_queue(queue: Any) -> Any:
    """The argument `queue`, if it can be one."""
    if queue is not None and not (hasattr(queue, "int_ptr") and
                                  hasattr(queue, "context")):
        raise TypeError(f"queue: {type(queue).__name__}; a CommandQueue of "
                        "pyopencl is needed")
    return queue


def handle(kind: str, of: Any) -> Any:
    """pyopencl's object as OpenCL's handle of that kind."""
    return ffi.cast(kind, of.int_ptr)


class Device:
    """An OpenCL context with one device, a queue, and hbil on it.

    Only one thread at a time may use it: `lock`.
    """

    def __init__(self, context: Any, device: Any) -> None:
        self.cl_context, self.cl_device = context, device
        self.lock = threading.RLock()
        self.queues: dict = {}
        self.plans: OrderedDict = OrderedDict()  # of process()
        out = ffi.new("hbil_context **")
        check(lib.hbil_context_create(context, device, out))
        self.context = owned(out[0], lib.hbil_context_destroy)
        folder = os.environ.get("HBIL_PROGRAM_DIR")
        if folder:
            self.check(lib.hbil_context_set_program_folder(
                self.context, folder.encode()))

    def check(self, status: int) -> None:
        check(status, self.context)

    def owned(self, made: Any, release: Callable[[Any], Any]) -> Any:
        """owned(), for what one thread at a time may use: any may let it go."""
        def let_go(gone: Any) -> None:
            # at the program's end, a thread that has ended may hold the lock
            if self.lock.acquire(blocking=not sys.is_finalizing()):
                try:
                    release(gone)
                finally:
                    self.lock.release()
        return owned(made, let_go)

    def queue(self, profiling: bool = False) -> Any:
        """A queue of this package, in order."""
        if profiling not in self.queues:
            status = ffi.new("cl_int *")
            made = cl.clCreateCommandQueue(
                self.cl_context, self.cl_device,
                cl.CL_QUEUE_PROFILING_ENABLE if profiling else 0, status)
            check_opencl(status[0], "making a queue")
            self.queues[profiling] = owned(made, cl.clReleaseCommandQueue)
        return self.queues[profiling]

    def buffer(self, size: int, writable: bool) -> Any:
        status = ffi.new("cl_int *")
        made = cl.clCreateBuffer(
            self.cl_context, cl.CL_MEM_WRITE_ONLY if writable else
            cl.CL_MEM_READ_ONLY, size, ffi.NULL, status)
        check_opencl(status[0], f"making a buffer of {size} bytes")
        return owned(made, cl.clReleaseMemObject)


_opened: "OrderedDict[Any, Device]" = OrderedDict()
_opening = threading.Lock()
_DEVICES_MOST = 4  # pyopencl's contexts among them, which programs make anew


def _add(key: Any, made: Device) -> Device:
    _opened[key] = made
    while len(_opened) > _DEVICES_MOST:
        _opened.popitem(last=False)
    return made


def open_device(wanted: Union[None, int, str]) -> Device:
    with _opening:
        check_process()
        if wanted in _opened:
            return _opened[wanted]
        device = _choose(wanted)
        platform = _device_info(device, cl.CL_DEVICE_PLATFORM,
                                "cl_platform_id *")[0]
        properties = ffi.new("cl_context_properties[]", [
            cl.CL_CONTEXT_PLATFORM,
            int(ffi.cast("cl_context_properties", platform)), 0])
        status = ffi.new("cl_int *")
        context = cl.clCreateContext(properties, 1, ffi.new(
            "cl_device_id *", device), ffi.NULL, ffi.NULL, status)
        check_opencl(status[0], f"device {_name(device)}")
        return _add(wanted, Device(owned(context, cl.clReleaseContext), device))


def device_of_queue(queue: Any) -> Device:
    """The device of pyopencl's queue, in its context."""
    with _opening:
        check_process()
        context = handle("cl_context", queue.context)
        device = handle("cl_device_id", queue.device)
        key = (queue.context.int_ptr, queue.device.int_ptr)
        if key in _opened:
            return _opened[key]
        # retained, so that no other context can have the same address
        check_opencl(cl.clRetainContext(context), "retaining a context")
        return _add(key, Device(owned(context, cl.clReleaseContext), device))


def _waits(events: Iterable[Any]) -> Any:
    events = list(events)
    return len(events), ffi.new("cl_event[]", events) if events else ffi.NULL


def write(queue: Any, buffer: Any, array: np.ndarray, blocking: bool,
          after: Iterable[Any] = ()) -> List[Any]:
    """Copies an array to a buffer, behind events.  If it isn't blocking, returns
    the event that tells when that is done."""
    event = ffi.NULL if blocking else ffi.new("cl_event *")
    count, events = _waits(after)
    check_opencl(cl.clEnqueueWriteBuffer(
        queue, buffer, blocking, 0, array.nbytes,
        ffi.from_buffer(array.reshape(-1).view(np.uint8)), count, events,
        event), "writing a buffer")
    return [] if blocking else [owned(event[0], cl.clReleaseEvent)]


def read(queue: Any, buffer: Any, array: np.ndarray, after: Any) -> None:
    """Copies a buffer to an array, behind an event."""
    count, events = _waits([after])
    check_opencl(cl.clEnqueueReadBuffer(
        queue, buffer, True, 0, array.nbytes,
        ffi.from_buffer(array.reshape(-1).view(np.uint8), require_writable=True),
        count, events, ffi.NULL), "reading a buffer")


def enqueue(device: Device, function: Any, *arguments: Any,
            after: Iterable[Any] = ()) -> None:
    """Calls a function of hbil that ends with a wait list and an event, which
    nobody waits for: what comes later is ordered by the library."""
    count, events = _waits(after)
    device.check(function(*arguments, count, events, ffi.NULL))


def enqueue_for_event(device: Device, function: Any, *arguments: Any,
                      after: Iterable[Any] = ()) -> Any:
    """The same, with the event."""
    event = ffi.new("cl_event *")
    count, events = _waits(after)
    device.check(function(*arguments, count, events, event))
    return owned(event[0], cl.clReleaseEvent)

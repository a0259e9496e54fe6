#!/usr/bin/python3
"""hbil from Python: G-buffers in pyopencl buffers, results in numpy arrays.

cffi reads the declarations from the installed header, so no struct has to be
declared again.  On Debian: apt-get install libhbil-dev python3-cffi
python3-numpy python3-pyopencl.
"""
import re
import subprocess
import sys

import cffi
import numpy as np
import pyopencl as cl

WIDTH, HEIGHT = 320, 180


def load_hbil():
    """The library, and what its header declares."""
    include = subprocess.run(
        ["pkg-config", "--variable=includedir", "hbil"],
        check=True, capture_output=True, text=True).stdout.rstrip()
    text = ""
    for name in ("hbil_base", "hbil_formats", "hbil_config", "hbil_frame",
                 "hbil"):
        with open(f"{include}/hbil/{name}.h", encoding="utf-8") as header:
            part = re.sub(r"/\*.*?\*/", "", header.read(), flags=re.DOTALL)
        text += part.split('extern "C" {')[1].rsplit("#ifdef __cplusplus")[0]
    text = re.sub(r"^#(\\\n|.)*$", "", text, flags=re.MULTILINE)
    ffi = cffi.FFI()
    ffi.cdef("""
        typedef struct _cl_context *cl_context;
        typedef struct _cl_device_id *cl_device_id;
        typedef struct _cl_command_queue *cl_command_queue;
        typedef struct _cl_mem *cl_mem;
        typedef struct _cl_event *cl_event;
        typedef uint32_t cl_uint;
        typedef cl_uint cl_bool;
    """ + text.replace("HBIL_API", ""))
    return ffi, ffi.dlopen("libhbil.so.1")


ffi, lib = load_hbil()


def handle(kind, of):
    """pyopencl's object as OpenCL's handle of that kind."""
    return ffi.cast(kind, of.int_ptr)


class Hbil:
    """A context of hbil, which turns failures into exceptions."""

    def __init__(self, context, device):
        out = ffi.new("hbil_context **")
        status = lib.hbil_context_create(
            handle("cl_context", context), handle("cl_device_id", device), out)
        self.handle = ffi.gc(out[0], lib.hbil_context_destroy)
        self.check(status)

    def check(self, status):
        if status != lib.HBIL_SUCCESS:
            raise RuntimeError(
                ffi.string(lib.hbil_status_string(status)).decode() + ": "
                + ffi.string(lib.hbil_context_message(self.handle)).decode())

    def plan(self, **settings):
        """A plan; settings are groups of members, or members by themselves."""
        config = ffi.new("hbil_config *")
        lib.hbil_config_init_sized(config, ffi.sizeof("hbil_config"))
        for name, value in settings.items():
            if isinstance(value, dict):
                for member, chosen in value.items():
                    setattr(getattr(config, name), member, chosen)
            else:
                setattr(config, name, value)
        out = ffi.new("hbil_plan **")
        self.check(lib.hbil_plan_create(self.handle, config, out))
        return ffi.gc(out[0], lib.hbil_plan_destroy)

    def enqueue(self, plan, queue, camera, images, wait_for=()):
        """Lights one frame behind the events; an event of pyopencl."""
        frame = ffi.new("hbil_frame *")
        lib.hbil_frame_init_sized(frame, ffi.sizeof("hbil_frame"))
        frame.camera = camera
        for name, buffer in images.items():
            getattr(frame, name).buffer = handle("cl_mem", buffer)
        waits = [handle("cl_event", event) for event in wait_for]
        event = ffi.new("cl_event *")
        self.check(lib.hbil_enqueue_frame(
            plan, handle("cl_command_queue", queue), frame, len(waits),
            waits or ffi.NULL, event))
        return cl.Event.from_int_ptr(int(ffi.cast("uintptr_t", event[0])),
                                     retain=False)


def draw_corner(camera):
    """Depth, and normals as planes, of a floor, a left and a back wall."""
    x, y = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
    with np.errstate(divide="ignore"):
        floor = 1 / np.maximum((y - camera["cy"]) / camera["fy"], 0)
        wall = 2 / np.maximum((camera["cx"] - x) / camera["fx"], 0)
    depth = np.minimum(5, np.minimum(floor, wall))
    normal = np.stack([depth == wall,
                       -1.0 * ((depth == floor) & (depth != wall)),
                       -1.0 * ((depth != floor) & (depth != wall))])
    return depth.astype(np.float32), normal.astype(np.float32)


def main():
    device = next(device for platform in cl.get_platforms()
                  for device in platform.get_devices())
    context = cl.Context([device])
    queue = cl.CommandQueue(context)
    hbil = Hbil(context, device)
    print("hbil", ffi.string(lib.hbil_version()).decode(), "on", device.name)

    camera = {"fx": 200, "fy": 200, "cx": WIDTH / 2, "cy": HEIGHT / 2,
              "world_from_view": np.eye(4).ravel().tolist()}
    depth, normal = draw_corner(camera)
    direct = np.ones((3, HEIGHT, WIDTH), np.float32)
    near_irradiance, ao = np.empty_like(direct), np.empty_like(depth)

    planes = (lib.HBIL_FLOAT32, 4)  # component, bytes from a pixel to the next: planar
    plan = hbil.plan(
        width=WIDTH, height=HEIGHT,
        inputs={"depth": planes, "normal": planes, "direct": planes},
        outputs={"near_irradiance": planes, "ao": planes})
    flags = cl.mem_flags.READ_WRITE
    images = {name: cl.Buffer(context, flags, array.nbytes) for name, array in
              [("depth", depth), ("normal", normal), ("direct", direct),
               ("near_irradiance", near_irradiance), ("ao", ao)]}
    uploads = [cl.enqueue_copy(queue, images[name], array, is_blocking=False)
               for name, array in [("depth", depth), ("normal", normal),
                                   ("direct", direct)]]
    lit = hbil.enqueue(plan, queue, camera, images, wait_for=uploads)
    for name, array in [("near_irradiance", near_irradiance), ("ao", ao)]:
        cl.enqueue_copy(queue, array, images[name], wait_for=[lit])

    print(f"mean visibility {ao.mean():.4f}, near light {near_irradiance.mean():.4f}")
    # neither open nor closed, and lit by what blocks; false for NaN, too
    return 0 if 0.5 < ao.mean() < 0.99 and near_irradiance.mean() > 0.1 else 1


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Prepares a Blender file for hbil, and writes the cameras that hbil needs.

    blender file.blend --python hbil_export_camera.py
    blender -b file.blend --python hbil_export_camera.py -a
    blender -b file.blend --python hbil_export_camera.py -- --views views

Run once, it switches on the passes that hbil reads, sets the output to OpenEXR
MultiLayer, and writes the camera of every frame of the scene's range beside the
picture that Blender writes: frame_0001.json for frame_0001.exr.  While Blender
stays open it also writes the camera of each frame that is rendered, after
whatever has changed; installed as an add-on, it does that in every file.

With --views it does none of that, but renders six small pictures of what
surrounds the camera in the present frame, into that folder.

It understands lens shifts, sensor fits, pixel aspects, orthographic cameras,
cropped borders, stereo and several cameras (one camera file for each eye).
Panoramas and fisheyes have no such camera: it says so and stops.
"""

bl_info = {
    "name": "hbil camera export",
    "description": "Writes the cameras of rendered frames as hbil reads them",
    "author": "the hbil authors",
    "version": (1, 0),
    "blender": (3, 4, 0),
    "category": "Render",
}

import json
import math
import os
import struct
import sys

import bpy
from bpy.app.handlers import persistent
from mathutils import Matrix, Vector

PASSES = ("combined", "z", "normal", "position", "vector", "diffuse_direct",
          "diffuse_indirect", "diffuse_color", "emit", "environment")


def switch_on_passes(scene):
    """Passes of all view layers, and a file that holds them."""
    for layer in scene.view_layers:
        for name in PASSES:
            if hasattr(layer, "use_pass_" + name):
                setattr(layer, "use_pass_" + name, True)
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):  # Blender 5
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    # DWAA and DWAB store every channel that ends in .Y with losses
    if settings.exr_codec in ("DWAA", "DWAB"):
        settings.exr_codec = "ZIP"


def tell_of_blur(scene):
    """What mixes several places in one pixel, which no depth describes."""
    blurs = []
    if scene.render.use_motion_blur:
        blurs.append("motion blur")
    if scene.camera and scene.camera.data.dof.use_dof:
        blurs.append("depth of field")
    if blurs:
        print("hbil: warning: %s is on: passes then hold several places in one "
              "pixel, and with motion blur Vector is 0; switch it off for "
              "these frames" % " and ".join(blurs), file=sys.stderr)
    return blurs


def picture_size(render):
    """Pixels of the whole picture, in whole numbers as Blender computes it."""
    share = render.resolution_percentage
    return render.resolution_x * share // 100, render.resolution_y * share // 100


def edge(border, pixels):
    """Where a border lies, in pixels.  Blender multiplies floats: .699999988 of
    320 pixels is 224, where doubles would make it 223."""
    (product,) = struct.unpack("f", struct.pack("f", border * pixels))
    return int(product)


def cropped(render, width, height):
    """The left and upper edge and the size of what is written, in pixels."""
    if not (render.use_border and render.use_crop_to_border):
        return 0, 0, width, height
    left, right = (edge(b, width) for b in
                   (render.border_min_x, render.border_max_x))
    low, high = (edge(b, height) for b in
                 (render.border_min_y, render.border_max_y))
    return left, height - high, right - left, high - low


def eyes(render):
    """The views that are rendered; none if there is one only."""
    return [v for v in render.views if v.use] if render.use_multiview else []


def camera_of(scene, eye):
    """The camera object of an eye: its own, by the suffix of its name."""
    camera = scene.camera
    if eye is None or scene.render.views_format != "MULTIVIEW":
        return camera
    for view in eyes(scene.render):
        if view.camera_suffix and camera.name.endswith(view.camera_suffix):
            name = camera.name[:-len(view.camera_suffix)] + eye.camera_suffix
            return scene.objects.get(name, camera)
    return camera


def stereo(camera, eye):
    """What Blender changes for an eye of a stereo camera: where it is, in the
    camera's own space, and how far the picture is shifted, in sensor widths."""
    data = camera.data.stereo
    left = eye.name == "left"
    if data.pivot == ("LEFT" if left else "RIGHT"):
        return Matrix.Identity(4), 0.0
    part = 0.5 if data.pivot == "CENTER" else 1.0
    side = part if left else -part
    between, distance = data.interocular_distance, data.convergence_distance
    place = Matrix.Translation((-between * side, 0, 0))
    if data.convergence_mode == "TOE":
        angle = math.atan(between / 2 / distance)
        turned = Matrix.Rotation(-angle if left else angle, 4, "Y")
        # about the middle between the eyes, or, from the one that stays where
        # it is, half before the way to the other and half behind it
        place = place @ turned if part < 1 else turned @ place @ turned
    shift = 0.0
    if data.convergence_mode == "OFFAXIS":
        shift = (between / camera.data.sensor_width *
                 camera.data.lens / distance * side)
    return place, shift


def describe(scene, eye=None, graph=None):
    """The camera of the present frame as hbil reads it.  graph: what was
    evaluated for it; the context's by default."""
    render, camera = scene.render, camera_of(scene, eye)
    if camera is None:
        raise RuntimeError("hbil: the scene has no camera")
    if camera.data.type not in ("PERSP", "ORTHO"):
        raise RuntimeError(
            "hbil: %s is a %s camera; hbil needs perspective or orthographic "
            "ones" % (camera.name, camera.data.type.lower()))
    width, height = picture_size(render)
    graph = graph or bpy.context.evaluated_depsgraph_get()
    seen = camera.evaluated_get(graph)
    place, shift = Matrix.Identity(4), 0.0
    if eye is not None and render.views_format == "STEREO_3D":
        place, shift = stereo(seen, eye)
    p = seen.calc_matrix_camera(graph, x=width, y=height,
                                scale_x=render.pixel_aspect_x,
                                scale_y=render.pixel_aspect_y)
    orthographic = seen.data.type == "ORTHO"
    across = (p[0][3], p[1][3]) if orthographic else (-p[0][2], -p[1][2])
    left, top, wide, high = cropped(render, width, height)
    to_world = seen.matrix_world.normalized() @ place
    fx = p[0][0] * width / 2
    return {
        "projection": "orthographic" if orthographic else "perspective",
        "camera_to_world": [list(row) for row in to_world],
        "fx": fx,
        "fy": p[1][1] * height / 2,
        "cx": width / 2 * (1 + across[0]) - left -
              shift * seen.data.sensor_width / seen.data.lens * fx,
        "cy": height / 2 * (1 - across[1]) - top,
        "resolution": [wide, high],
        "near": seen.data.clip_start,
        "far": seen.data.clip_end,
    }


def write(path, camera):
    """A file that appears complete or not at all."""
    folder = os.path.dirname(path)
    if folder:
        os.makedirs(folder, exist_ok=True)
    temporary = path + ".tmp%d" % os.getpid()
    with open(temporary, "w") as file:
        json.dump(camera, file, indent=1)
    os.replace(temporary, path)


def written_picture(render, eye):
    """The picture that has just been written: an animation's frame, or a single
    picture, whose name has no number."""
    numbered = bpy.path.abspath(render.frame_path(view=eye.name if eye else ""))
    single = bpy.path.abspath(render.filepath)
    ending = render.file_extension
    stem = single[:-len(ending)] if single.endswith(ending) else single
    single = stem + (eye.file_suffix if eye else "") + ending
    there = [p for p in (numbered, single) if os.path.exists(p)]
    return max(there, key=os.path.getmtime) if there else numbered


def describe_all(scene, graph=None):
    return [(eye, describe(scene, eye, graph))
            for eye in eyes(scene.render) or [None]]


def write_cameras(scene, picture_of, cameras):
    """The camera files of a frame.  picture_of: the name of an eye's picture."""
    together = scene.render.image_settings.views_format == "MULTIVIEW"
    written = []
    for eye, camera in cameras:
        picture = picture_of(scene.render, None if together else eye)
        stem = os.path.splitext(bpy.path.abspath(picture))[0]
        name = stem + ("." + eye.name if eye and together else "") + ".json"
        write(name, camera)
        written.append(name)
    return written


def numbered_picture(render, eye):
    return render.frame_path(view=eye.name if eye else "")


def write_all_cameras(scene):
    """The camera files of all frames of the scene's range."""
    before = scene.frame_current, scene.frame_subframe
    written = []
    for frame in range(scene.frame_start, scene.frame_end + 1,
                       scene.frame_step):
        scene.frame_set(frame)
        written += write_cameras(scene, numbered_picture,
                                 describe_all(scene))
    scene.frame_set(before[0], subframe=before[1])
    return written


# While an animation is rendered, the context shows the frame before it began.
# What is evaluated for a frame is handed to the handler of its change alone.
rendered = {"running": False, "frame": None, "cameras": None}


@persistent
def before_rendering(*_):
    rendered.update(running=True, frame=None, cameras=None)


@persistent
def after_rendering(*_):
    rendered.update(running=False, frame=None, cameras=None)


@persistent
def after_frame_change(scene, graph=None):
    if rendered["running"]:
        rendered.update(frame=scene.frame_current,
                        cameras=describe_all(scene, graph))


@persistent
def after_writing(scene, *_):
    cameras = rendered["cameras"]
    if cameras is None or rendered["frame"] != scene.frame_current:
        cameras = describe_all(scene)
    write_cameras(scene, written_picture, cameras)


HANDLERS = (("render_init", before_rendering),
            ("frame_change_post", after_frame_change),
            ("render_write", after_writing),
            ("render_complete", after_rendering),
            ("render_cancel", after_rendering))


def unregister():
    for event, function in HANDLERS:
        handlers = getattr(bpy.app.handlers, event)
        for other in [h for h in handlers if h.__name__ == function.__name__
                      and h.__module__ == function.__module__]:
            handlers.remove(other)


def register():
    unregister()
    for event, function in HANDLERS:
        getattr(bpy.app.handlers, event).append(function)


def render_views(scene, folder):
    """Six pictures of what surrounds the camera, for hbil process --view."""
    render = scene.render
    camera = bpy.data.objects.new("view", bpy.data.cameras.new("view"))
    scene.collection.objects.link(camera)
    camera.data.angle = math.radians(90)
    camera.location = scene.camera.matrix_world.translation
    camera.rotation_mode = "QUATERNION"
    scene.camera = camera
    render.resolution_x = render.resolution_y = 256
    render.resolution_percentage = 100
    render.use_border = render.use_multiview = False
    for name, direction in (("px", (1, 0, 0)), ("nx", (-1, 0, 0)),
                            ("py", (0, 1, 0)), ("ny", (0, -1, 0)),
                            ("pz", (0, 0, 1)), ("nz", (0, 0, -1))):
        camera.rotation_quaternion = Vector(direction).to_track_quat("-Z", "Y")
        bpy.context.view_layer.update()
        render.filepath = os.path.join(os.path.abspath(folder),
                                       "face_" + name + ".exr")
        bpy.ops.render.render(write_still=True)


def main(words):
    scene = bpy.context.scene
    switch_on_passes(scene)
    tell_of_blur(scene)
    if words[:1] == ["--views"] and len(words) == 2:
        register()
        render_views(scene, words[1])
        return
    files = write_all_cameras(scene)
    register()
    print("hbil: %d camera files, from %s to %s" %
          (len(files), files[0], files[-1]))


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])

"""Renders a small scene with Blender in all that hbil_export_camera.py knows of:
    python3 blender_scene.py EXAMPLES FOLDER
or  blender -b --python blender_scene.py -- EXAMPLES FOLDER"""
import os
import sys

import bpy

words = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
examples, out = words
sys.path.insert(0, examples)
import hbil_export_camera as export  # noqa: E402

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
render = scene.render
render.engine = "CYCLES"
scene.cycles.samples = 1
scene.cycles.use_denoising = False
# positions of one place in each pixel
scene.cycles.pixel_filter_type = "GAUSSIAN"
scene.cycles.filter_width = 0.01
render.resolution_x, render.resolution_y = 200, 100
render.resolution_percentage = 57  # whole numbers: 114 x 57, by doubles 113
bpy.ops.mesh.primitive_plane_add(size=20)
bpy.ops.mesh.primitive_cube_add(size=2, location=(0, 0, 1))
bpy.ops.object.light_add(type="POINT", location=(2, -3, 5))
bpy.context.object.data.energy = 500


def new_camera(name, place, turn):
    camera = bpy.data.objects.new(name, bpy.data.cameras.new(name))
    scene.collection.objects.link(camera)
    camera.location, camera.rotation_euler = place, turn
    return camera


camera = scene.camera = new_camera("one", (1, -7, 4), (1.1, 0.1, 0.2))
lens = camera.data
export.switch_on_passes(scene)
assert all(layer.use_pass_position for layer in scene.view_layers)
assert export.tell_of_blur(scene) == []
render.use_motion_blur = lens.dof.use_dof = True
assert export.tell_of_blur(scene) == ["motion blur", "depth of field"]
render.use_motion_blur = lens.dof.use_dof = False
export.register()


def single(name):
    render.filepath = os.path.join(out, name + ".exr")
    bpy.ops.render.render(write_still=True)


single("plain")
lens.shift_x, lens.shift_y, lens.sensor_fit = 0.1, -0.07, "VERTICAL"
render.pixel_aspect_x = 1.25
single("shift")
render.pixel_aspect_x = 1
lens.type, lens.ortho_scale = "ORTHO", 9
single("parallel")
lens.type, lens.sensor_fit = "PERSP", "AUTO"
render.use_border = render.use_crop_to_border = True
# on whole pixels as floats, and just below them as doubles
render.resolution_percentage = 50
(render.border_min_x, render.border_max_x, render.border_min_y,
 render.border_max_y) = 0.11, 0.63, 0.32, 0.7
single("crop")
render.resolution_percentage = 57
render.use_border = False
render.use_multiview = True
render.views_format = "STEREO_3D"
lens.stereo.interocular_distance, lens.stereo.convergence_distance = 0.6, 6
render.image_settings.views_format = "MULTIVIEW"
for mode, pivot in (("OFFAXIS", "CENTER"), ("PARALLEL", "LEFT"), ("TOE", "RIGHT")):
    lens.stereo.convergence_mode, lens.stereo.pivot = mode, pivot
    single("stereo_" + mode)
render.image_settings.views_format = "INDIVIDUAL"
single("eyes")
render.views_format = render.image_settings.views_format = "MULTIVIEW"
camera.name = "one_L"
new_camera("one_R", (3, -6, 3), (1.2, 0, 0.4))
single("cameras")
render.use_multiview = False

# an animation, whose cameras are also written before it is rendered
camera.keyframe_insert("location", frame=1)
camera.location.x += 1
camera.keyframe_insert("location", frame=2)
scene.frame_start, scene.frame_end = 1, 2
render.filepath = os.path.join(out, "walk_")
for name in export.write_all_cameras(scene):
    os.rename(name, name + ".before")
bpy.ops.render.render(animation=True)

lens.type = "PANO"
try:
    export.describe(scene)
except RuntimeError as error:
    print(error)

# Blender's Python module may crash while it is unloaded
export.unregister()
sys.stdout.flush()
os._exit(0)

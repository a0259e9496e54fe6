#!/usr/bin/python3
"""hbil from Python, as in a notebook: a picture, and a camera that moves through
a room, beside what it would be without a radiance cache; all of it drawn.

On Debian: apt-get install python3-hbil.
"""
# %% A picture of numpy arrays.
import numpy as np

import hbil
import hbil.demo

depth, normal, albedo, direct, camera = hbil.demo.room(320, 180)
layers = hbil.process(depth, normal, albedo, direct, camera)
for name, layer in layers.items():
    print(f"{name:16} {str(layer.shape):16} mean {layer.mean():.4f}")

# %% What light does: direct light alone, with indirect light, and occlusion.
before = albedo * direct / np.pi
occlusion = np.repeat(layers["ao"][..., None], 3, axis=-1)
hbil.demo.save("room.png", np.hstack([before, layers["beauty"], 2 * occlusion]),
               exposure=0.5)

# %% A narrow part of the room.  The walls beside it are outside the picture,
# and a view of the whole room tells the radiance cache of them.
part = (slice(50, 130), slice(110, 210))
narrow = [plane[part] for plane in (depth, normal, albedo, direct)]
moved = {**camera, "cx": camera["cx"] - 110, "cy": camera["cy"] - 50}
room = hbil.View(depth, normal, albedo, direct, camera)
with hbil.Sequence(cache=False) as alone, hbil.Sequence(views=[room]) as informed:
    for _ in range(4):
        without = alone.process(*narrow, moved)["indirect"]
        with_view = informed.process(*narrow, moved)["indirect"]
hbil.demo.save("part.png", np.hstack([layers["indirect"][part], without,
                                      with_view]), exposure=0.3)
print("mean indirect light: of the whole picture", layers["indirect"][part].mean(
    axis=(0, 1)), "without a view", without.mean(axis=(0, 1)), "with it",
    with_view.mean(axis=(0, 1)))

"""hbil: indirect light and ambient occlusion from G-buffers, through OpenCL.

    import hbil
    layers = hbil.process(depth, normal, albedo, direct, camera)

lights one picture, and hbil.Sequence frames in order, with a radiance cache.
The conventions are those of hbil.h:

* In view space x points towards the next column of pixels, y towards the next
  row, and z forward: normals of a floor are (0, -1, 0).
* Depth is z, in world units of your choice; 0, NaN, infinity and what is beyond
  the option sky_depth are sky.
* Light is linear.  `direct` is irradiance E, in W/m2: a white diffuse surface
  sends E / pi.  Radiance is in W/(m2 sr).

Failures of the library are hbil.Error, with its message.  Arguments of a wrong
shape are a ValueError, and of a wrong type a TypeError, in one line that begins
with the argument's name.
"""
from ._arrays import LAYERS
from ._frames import Sequence, View, process
from ._library import Error, version
from ._opencl import devices
from ._settings import options

__all__ = ["Error", "LAYERS", "Sequence", "View", "devices", "options",
           "process", "version"]
__version__ = version()

#!/usr/bin/python3
"""hbil from Python on your own queue: G-buffers and results are pyopencl's
arrays, and nothing is copied to the host.

On Debian: apt-get install python3-hbil python3-pyopencl.
"""
import hbil
import hbil.demo
import pyopencl as cl
import pyopencl.array

device = next(device for platform in cl.get_platforms()
              for device in platform.get_devices())
queue = cl.CommandQueue(cl.Context([device]))
*planes, camera = hbil.demo.room(320, 180)
planes = [cl.array.to_device(queue, plane) for plane in planes]
layers = hbil.process(*planes, camera, far_field="frame")
ao, near = layers["ao"].get(), layers["near_irradiance"].get()
print(f"hbil {hbil.version()} on {device.name}: mean visibility {ao.mean():.4f}, "
      f"near light {near.mean():.4f}")
# neither open nor closed, and lit by what blocks; false for NaN, too
assert 0.3 < ao.mean() < 0.99 and near.mean() > 0.1

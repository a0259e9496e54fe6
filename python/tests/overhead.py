#!/usr/bin/python3
"""Prints the milliseconds that the package itself takes for a frame, without
the time inside libhbil and OpenCL, and those of the whole call.

    PYTHONPATH=pythonpath python3 overhead.py [WIDTH HEIGHT]
"""
import sys
import time

import hbil
import hbil.demo
from hbil import _frames, _opencl, _settings

RUNS = 9


class Timed:
    """A shared library whose calls are timed."""
    seconds = 0.0

    def __init__(self, library):
        self.library = library

    def __getattr__(self, name):
        found = getattr(self.library, name)
        if not callable(found):
            return found

        def call(*arguments):
            start = time.perf_counter()
            result = found(*arguments)
            Timed.seconds += time.perf_counter() - start
            return result
        return call


def main():
    size = [int(word) for word in sys.argv[1:]] or [1280, 720]
    for module in _frames, _opencl, _settings:
        for name in "lib", "cl":
            if hasattr(module, name):
                setattr(module, name, Timed(getattr(module, name)))
    room = hbil.demo.room(*size)
    sequence = hbil.Sequence(cache=False)
    for name, light in (("process()", hbil.process),
                        ("Sequence.process()", sequence.process)):
        light(*room)  # builds kernels
        own, whole = [], []
        for _ in range(RUNS):
            Timed.seconds = 0.0
            start = time.perf_counter()
            light(*room)
            whole.append(time.perf_counter() - start)
            own.append(whole[-1] - Timed.seconds)
        print(f"{name:20} median of {RUNS}: {1e3 * sorted(own)[RUNS // 2]:6.2f} ms "
              f"of {1e3 * sorted(whole)[RUNS // 2]:8.2f} ms")


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""Puts the package together in a folder that PYTHONPATH can name.

    package.py FOLDER INCLUDE [LIBRARY]

FOLDER/hbil becomes the package, with declarations from the headers in INCLUDE,
and with LIBRARY (libhbil.so) inside; without it, the package loads the
installed libhbil.so.1.
"""
import os
import shutil
import sys

sys.dont_write_bytecode = True  # the sources may be read-only
import declarations  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))


def complete(package, include, library=None):
    """Adds what is made when the package is built to a copy of its sources."""
    declarations.write(include, os.path.join(package, "_declarations.py"))
    if library:
        shutil.copyfile(library, os.path.join(package, "libhbil.so.1"))


def assemble(folder, include, library=None):
    package = os.path.join(folder, "hbil")
    shutil.rmtree(package, ignore_errors=True)
    os.makedirs(package)
    for name in os.listdir(os.path.join(HERE, "hbil")):
        if name.endswith(".py") and name != "_declarations.py" or \
                name == "py.typed":
            shutil.copyfile(os.path.join(HERE, "hbil", name),
                            os.path.join(package, name))
    complete(package, include, library)


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    assemble(*sys.argv[1:])

"""Builds the package: declarations from the headers, and the library.

HBIL_SOURCE is the tree of hbil, by default the folder above this one.
HBIL_LIBRARY is the libhbil.so that the package gets; "installed" stands for none:
it loads the installed one.  By default it is what is built in build/, else it is
built here.
"""
import os
import re
import subprocess
import sys

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.dist import Distribution

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:  # setuptools before 70
    from wheel.bdist_wheel import bdist_wheel

HERE = os.path.dirname(os.path.abspath(__file__))
SOURCE = os.environ.get("HBIL_SOURCE") or os.path.dirname(HERE)
INCLUDE = os.path.join(SOURCE, "include")
sys.path.insert(0, HERE)
import package  # noqa: E402


def version():
    with open(os.path.join(INCLUDE, "hbil", "hbil_base.h"),
              encoding="utf-8") as header:
        return ".".join(re.findall(
            r"#define HBIL_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)", header.read()))


def build_library(folder):
    """The library alone, which needs no other one than OpenCL."""
    os.makedirs(folder, exist_ok=True)
    folder = os.path.abspath(folder)
    if not os.path.exists(os.path.join(SOURCE, "configure")):
        subprocess.run(["autoreconf", "-fi"], cwd=SOURCE, check=True)
    configure = os.path.relpath(os.path.join(SOURCE, "configure"), folder)
    subprocess.run([configure, "-q", "--disable-tool", "--disable-static"],
                   cwd=folder, check=True)
    subprocess.run(["make", "-s", f"-j{os.cpu_count()}", "libhbil.la"],
                   cwd=folder, check=True)
    return os.path.join(folder, ".libs", "libhbil.so.1")


def find_library(temporary):
    wanted = os.environ.get("HBIL_LIBRARY")
    if wanted:
        return None if wanted == "installed" else wanted
    built = os.path.join(SOURCE, "build", ".libs", "libhbil.so.1")
    return built if os.path.exists(built) else build_library(temporary)


def platform_tag(library):
    """manylinux_2_N_MACHINE: N is that of the newest symbol of glibc that the
    library needs.  OpenCL's loader remains the system's."""
    with open(library, "rb") as file:
        newest = max((int(minor) for minor in
                      re.findall(rb"\0GLIBC_2\.(\d+)", file.read())), default=17)
    # pip knows no manylinux_2_N below that of 2014
    return f"manylinux_2_{max(newest, 17)}_{os.uname().machine}"


class BuildPackage(build_py):
    def run(self):
        super().run()
        target = os.path.join(self.build_lib, "hbil")
        temporary = self.get_finalized_command("build").build_temp
        library = find_library(os.path.join(temporary, "libhbil"))
        package.complete(target, INCLUDE, library)


class Platform(Distribution):
    def has_ext_modules(self):
        return os.environ.get("HBIL_LIBRARY") != "installed"


class Wheel(bdist_wheel):
    def get_tag(self):
        if self.root_is_pure:
            return super().get_tag()
        command = self.get_finalized_command("build_py")
        library = os.path.join(command.build_lib, "hbil", "libhbil.so.1")
        return "py3", "none", platform_tag(library)


setup(version=version(), distclass=Platform,
      cmdclass={"build_py": BuildPackage, "bdist_wheel": Wheel})

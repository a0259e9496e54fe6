#!/usr/bin/python3
"""Writes hbil/_declarations.py: what hbil's headers declare, for cffi.

    declarations.py INCLUDE OUTPUT

INCLUDE is the folder that has hbil/hbil.h.  The C compiler (CC, else cc) reads
the headers, so nothing is declared a second time.  Of OpenCL's header the
types are taken that hbil's functions need, and the functions and numbers that
the package calls and names itself.
"""
import os
import re
import shlex
import subprocess
import sys

OPENCL_FUNCTIONS = (
    "clGetPlatformIDs clGetPlatformInfo clGetDeviceIDs clGetDeviceInfo "
    "clCreateContext clReleaseContext clCreateCommandQueue "
    "clReleaseCommandQueue clGetCommandQueueInfo clRetainContext "
    "clRetainCommandQueue clCreateBuffer clReleaseMemObject "
    "clEnqueueWriteBuffer clEnqueueReadBuffer clReleaseEvent clFinish").split()
OPENCL_NUMBERS = (
    "CL_SUCCESS CL_TRUE CL_FALSE CL_PLATFORM_NAME CL_DEVICE_NAME CL_DEVICE_TYPE "
    "CL_DEVICE_PLATFORM CL_DEVICE_TYPE_ALL CL_DEVICE_TYPE_GPU "
    "CL_CONTEXT_PLATFORM CL_QUEUE_CONTEXT CL_QUEUE_DEVICE "
    "CL_QUEUE_PROFILING_ENABLE CL_MEM_READ_ONLY CL_MEM_WRITE_ONLY").split()

# Attributes have parentheses, at most two deep within their own.
ATTRIBUTE = r"__attribute__\s*\(\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\)\)"


def preprocess(include):
    """The text of hbil's headers and of OpenCL's, and their macros."""
    done = subprocess.run(
        shlex.split(os.environ.get("CC", "cc")) + [
            "-E", "-dD", "-x", "c", "-DCL_TARGET_OPENCL_VERSION=120",
            "-I", include, "-"],
        input="#include <hbil/hbil.h>\n#include <hbil/hbil_stages.h>\n",
        check=True, capture_output=True, text=True)
    text = {"hbil": [], "CL": []}
    macros = {"hbil": {}, "CL": {}}
    owner = None
    for line in done.stdout.splitlines():
        marker = re.match(r'# \d+ "(.*)"', line)
        if marker:
            folder = os.path.basename(os.path.dirname(marker.group(1)))
            owner = folder if folder in text else None
        elif owner and line.startswith("#define "):
            macro = re.match(r"#define (\w+) +(.+)", line)
            if macro:
                macros[owner][macro.group(1)] = macro.group(2)
        elif owner and not line.startswith("#"):
            text[owner].append(line)
    return ({of: re.sub(ATTRIBUTE, "", "\n".join(lines))
             for of, lines in text.items()}, macros)


def whole_number(text):
    """The value of a macro such as 64, 0x1000 or (1 << 2), else None."""
    number = re.fullmatch(
        r"\(?\s*(0x[0-9a-fA-F]+|\d+)\s*(?:<<\s*(\d+)\s*)?\)?", text)
    if not number:
        return None
    return int(number.group(1), 0) << int(number.group(2) or 0)


def declarations(include):
    """C declarations as cffi.FFI.cdef() takes them."""
    text, macros = preprocess(include)
    types, functions = {}, {}
    for statement in text["CL"].split(";"):
        statement = " ".join(statement.split())
        simple = re.fullmatch(r"typedef [\w\s*]+?\b(\w+)", statement)
        called = re.fullmatch(r"(?:extern )?([^=]*?\b(cl\w+) ?\(.*\))", statement)
        if simple:
            types[simple.group(1)] = statement
        elif called:
            functions[called.group(2)] = called.group(1)
    body = [functions[name] + ";" for name in OPENCL_FUNCTIONS]
    body.append(text["hbil"])
    # those types that are used, each behind those that it needs
    needed = []

    def need(words):
        for name in re.findall(r"\bcl_\w+", words):
            if name in types and name not in needed:
                need(types[name].rpartition(name)[0])
                needed.append(name)

    need("\n".join(body))
    numbers = {name: whole_number(macros["CL"][name])
               for name in OPENCL_NUMBERS}
    for name, value in macros["hbil"].items():
        if whole_number(value) is not None:
            numbers[name] = whole_number(value)
    return "\n".join(
        [types[name] + ";" for name in needed] + body
        + [f"#define {name} {value}" for name, value in numbers.items()])


def write(include, output):
    """Writes the module, which needs cffi's backend alone."""
    import cffi
    ffi = cffi.FFI()
    ffi.set_source("hbil._declarations", None)
    ffi.cdef(declarations(include))
    ffi.emit_python_code(output)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    write(sys.argv[1], sys.argv[2])

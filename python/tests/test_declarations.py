"""What cffi was given is what the C compiler reads in the headers."""
import os
import re
import shlex
import subprocess
from pathlib import Path

import pytest

from hbil._arrays import INPUTS, LAYERS
from hbil._declarations import ffi
from hbil._library import lib

INCLUDE = Path(__file__).parents[2] / "include"


def is_complete(name):
    try:
        return ffi.sizeof(name) > 0
    except ffi.error:
        return False


STRUCTS = [name for name in ffi.list_types()[0] if name.startswith("hbil_")
           and ffi.typeof(name).kind == "struct" and is_complete(name)]
ENUMS = [name for name in ffi.list_types()[0]
         if name.startswith("hbil_") and ffi.typeof(name).kind == "enum"]


def headers():
    return "".join(path.read_text() for path in
                   sorted((INCLUDE / "hbil").glob("*.h")))


def test_everything_is_declared():
    text = re.sub(r"/\*.*?\*/", "", headers(), flags=re.DOTALL)
    types = set(re.findall(r"typedef (?:struct|enum) (hbil_\w+)", text))
    assert types and types <= set(ffi.list_types()[0])
    functions = re.findall(r"HBIL_API [^;(]*?(hbil_\w+)\(", text)
    assert len(functions) > 40
    for function in functions:
        assert getattr(lib, function)
    enumerators = {name for enum in ENUMS
                   for name in ffi.typeof(enum).relements}
    words = set(re.findall(r"\bHBIL_\w+(?= =)", text))
    assert words and words <= enumerators


def test_layout_is_the_compilers(tmp_path):
    lines = []
    for name in STRUCTS:
        lines.append((f"sizeof({name})", ffi.sizeof(name)))
        for member, field in ffi.typeof(name).fields:
            lines.append((f"offsetof({name}, {member})", field.offset))
            lines.append((f"sizeof((({name} *)0)->{member})",
                          ffi.sizeof(field.type)))
    for name in ENUMS:
        lines += [(word, value)
                  for word, value in ffi.typeof(name).relements.items()]
    assert len(lines) > 300
    source = tmp_path / "layout.c"
    source.write_text(
        "#define CL_TARGET_OPENCL_VERSION 120\n#include <hbil/hbil.h>\n"
        "#include <hbil/hbil_stages.h>\n"
        + "".join(f'_Static_assert((long)({what}) == {value}, "{what}");\n'
                  for what, value in lines))
    subprocess.run(shlex.split(os.environ.get("CC", "cc"))
                   + ["-std=c11", "-fsyntax-only", "-I", str(INCLUDE),
                      str(source)], check=True)


@pytest.mark.parametrize("group, table", [("hbil_inputs", INPUTS),
                                          ("hbil_outputs", LAYERS)])
def test_planes_are_those_of_the_header(group, table):
    planes = [name for name, field in ffi.typeof(group).fields
              if field.type is ffi.typeof("hbil_plane_format")]
    assert sorted(planes) == sorted(table)

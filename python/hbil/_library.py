"""The shared libraries, and how their failures become exceptions."""
from __future__ import annotations

import os
from typing import Any, Callable, List

from ._declarations import ffi

_beside = os.path.join(os.path.dirname(__file__), "libhbil.so.1")
# What the package brings comes before what is installed; HBIL_LIBRARY, the path
# of another one, before both.
lib = ffi.dlopen(os.environ.get("HBIL_LIBRARY") or
                 (_beside if os.path.exists(_beside) else "libhbil.so.1"))
cl = ffi.dlopen("libOpenCL.so.1")


class Error(Exception):
    """A failure of hbil or of OpenCL.

    status: the name of the hbil_status, such as "HBIL_INVALID_CONFIG", or
    "OPENCL" with a call of the package's own.
    """

    def __init__(self, message: str, status: str) -> None:
        super().__init__(message)
        self.status = status


def text(chars: Any) -> str:
    return ffi.string(chars).decode(errors="replace")


def version() -> str:
    """The running library's version, "major.minor.patch"."""
    return text(lib.hbil_version())


def check(status: int, context: Any = ffi.NULL) -> None:
    """Raises Error, with the message of an hbil_context or, without one, of
    this thread."""
    if status != lib.HBIL_SUCCESS:
        message = text(lib.hbil_context_message(context))
        raise Error(message or text(lib.hbil_status_string(status)),
                    ffi.typeof("hbil_status").elements[status])


def check_opencl(status: int, doing: str) -> None:
    if status != cl.CL_SUCCESS:
        raise Error(f"{doing}: OpenCL error {status}", "OPENCL")


_users: List[int] = []  # the process that called OpenCL first


def check_process() -> None:
    """OpenCL's drivers don't work in a child of fork()."""
    if not _users:
        _users.append(os.getpid())
    if os.getpid() not in _users:
        raise Error("OpenCL does not survive fork(): start processes by "
                    "multiprocessing's \"spawn\", or before the first picture",
                    "OPENCL")


def owned(handle: Any, release: Callable[[Any], Any]) -> Any:
    """The handle, which is released when nothing needs it any more, by the
    process that made it."""
    maker = os.getpid()

    def let_go(gone: Any) -> None:
        if os.getpid() == maker:
            release(gone)
    return ffi.gc(handle, let_go)

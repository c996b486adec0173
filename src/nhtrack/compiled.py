"""Compiles scalar functions to machine code, and keeps what was compiled for the next process.

`compiled` is numba's `njit` with the settings of this package. Compiled code is cached in a folder whose name is a
hash of every source that has compiled code: numba itself looks only at the file of the function it caches, not at the
functions that it calls, and would go on with old code after one of them has changed.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

Function = TypeVar("Function", bound=Callable[..., Any])

_PACKAGE = Path(__file__).parent
# Modules and rooms of the package that hold compiled code, each with those whose compiled code it calls.
_ROOMS: dict[str, tuple[str, ...]] = {
    "compiled": ("compiled",),
    "planar": ("compiled", "planar"),
    "settling": ("compiled", "settling"),
    "laws": ("compiled", "planar", "laws"),
    "simulation": ("compiled", "planar", "simulation"),
    "experiment": ("compiled", "planar", "settling", "laws", "simulation", "experiment"),
}
# Division by zero gives an infinity, as in NumPy; no reordering of sums, so that all runs have the same bits.
_SETTINGS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": False}
_NO_ARRAYS = {"_nrt": False}  # numba's runtime, which makes arrays and counts who holds them
_COMPLETE = "complete"
WRAPPERS = "nhtrack_law_"  # what names of modules begin with that hold the wrapper of a law


def compiled(function: Function) -> Function:
    """Returns a function that is compiled when it is first called with arguments of some types."""
    with _numba_cache(function) as kept:
        result: Function = numba.njit(cache=kept, **_SETTINGS)(function)
    return result


def compiled_loop(function: Function) -> Function:
    """Returns a compiled function that makes no array: all memory is passed in.

    numba then counts no references, which takes more time than the arithmetic where every robot has a view of its own.
    What makes an array, or returns one, does not compile.
    """
    with _numba_cache(function) as kept:
        result: Function = numba.njit(cache=kept, **_SETTINGS, **_NO_ARRAYS)(function)
    return result


def compiled_inside(function: Function) -> Function:
    """Returns a function that only a `compiled_loop` calls: it has no way in from Python, which takes long to compile.

    It makes no array either.
    """
    with _numba_cache(function) as kept:
        result: Function = numba.njit(
            cache=kept, no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True, **_SETTINGS, **_NO_ARRAYS
        )(function)
    return result


def compiled_for_address(arguments: int) -> Callable[[Function], Any]:
    """Returns the decorator of functions of so many pointers to float64 that machine code calls by their address.

    The result has the attribute `address`.
    """
    signature = types.void(*(arguments * [types.CPointer(types.float64)]))

    def decorate(function: Function) -> Any:
        with _numba_cache(function) as kept:
            return numba.cfunc(signature, cache=kept, nopython=True, error_model="numpy")(function)

    return decorate


@cache
def cache_folder(room: str = "experiment") -> Path | None:
    """Returns the folder of compiled code, or None where none can be written: then every process compiles anew.

    NUMBA_CACHE_DIR if it is set, else beside the package, else in the user's cache.

    Args:
        room: the part of the package whose code it is; by default the one that calls all others.
    """
    asked = os.environ.get("NUMBA_CACHE_DIR")
    user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    places = [Path(asked)] if asked else [_PACKAGE / "__pycache__", user / "nhtrack"]
    for place in places:
        folder = place / f"compiled-{room}-{_stamp(room)}"
        if _is_writable(folder):
            _sweep(folder, room)
            return folder
    return None


def is_complete() -> bool:
    """Returns whether all compiled code of the package is in the cache; True where there is none to fill."""
    folder = cache_folder()
    return folder is None or (folder / _COMPLETE).exists()


def mark_complete() -> None:
    """Notes in the cache that all compiled code of the package is in it."""
    folder = cache_folder()
    if folder is not None:
        (folder / _COMPLETE).touch()


@cache
def _stamp(room: str) -> str:
    """Returns a hash of all sources whose compiled code a room has or calls."""
    digest = hashlib.sha256()
    for name in _ROOMS[room]:
        module = _PACKAGE / f"{name}.py"
        for file in [module] if module.is_file() else sorted((_PACKAGE / name).rglob("*.py")):
            digest.update(file.relative_to(_PACKAGE).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def _sweep(folder: Path, room: str) -> None:
    """Removes compiled code of other states of the same sources, unless it was begun within the last ten minutes."""
    for other in folder.parent.glob(f"compiled-{room}-*"):
        try:
            if other != folder and other.stat().st_mtime < time.time() - 600:
                shutil.rmtree(other, ignore_errors=True)
        except OSError:
            continue  # another process was quicker


@contextmanager
def _numba_cache(function: Callable[..., Any]) -> Iterator[bool]:
    """Lets numba cache a function that is decorated inside into `cache_folder`, and yields whether it can.

    Functions of others are not cached by themselves, since what they call may change; the wrapper of a law is, and has
    a hash of all that in its name.
    """
    names = function.__module__.split(".")
    room = names[1] if len(names) > 1 and names[1] in _ROOMS else "laws"
    ours = names[0] == "nhtrack" or names[0].startswith(WRAPPERS)
    folder, before = cache_folder(room) if ours else None, numba.config.CACHE_DIR
    if folder is not None:
        numba.config.CACHE_DIR = str(folder)
    try:
        yield folder is not None
    finally:
        numba.config.CACHE_DIR = before


# Calls and memory by address ------------------------------------------------------------------------------------------


@intrinsic  # type: ignore[untyped-decorator]
def call_2(typing_context: Any, address: Any, a: Any, b: Any) -> Any:
    """Calls the C function at an address with two pointers."""
    return types.void(types.intp, types.intp, types.intp), _code_of_call


@intrinsic  # type: ignore[untyped-decorator]
def call_4(typing_context: Any, address: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
    """Calls the C function at an address with four pointers."""
    return types.void(*(5 * [types.intp])), _code_of_call


@intrinsic  # type: ignore[untyped-decorator]
def call_6(typing_context: Any, address: Any, a: Any, b: Any, c: Any, d: Any, e: Any, f: Any) -> Any:
    """Calls the C function at an address with six pointers."""
    return types.void(*(7 * [types.intp])), _code_of_call


def _code_of_call(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    word = ir.IntType(64)
    kind = ir.FunctionType(ir.VoidType(), [word] * (len(values) - 1))
    builder.call(builder.inttoptr(values[0], kind.as_pointer()), values[1:])
    return context.get_dummy_value()


def _memory_of(kind: Any) -> tuple[Any, Any]:
    """Returns what reads and what writes a value of a type at an address."""

    def pointer(context: Any, builder: Any, address: Any) -> Any:
        return builder.inttoptr(address, context.get_value_type(kind).as_pointer())

    @intrinsic  # type: ignore[untyped-decorator]
    def read(typing_context: Any, address: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return builder.load(pointer(context, builder, values[0]))

        return kind(types.intp), code

    @intrinsic  # type: ignore[untyped-decorator]
    def write(typing_context: Any, address: Any, value: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            builder.store(values[1], pointer(context, builder, values[0]))
            return context.get_dummy_value()

        return types.void(types.intp, kind), code

    return read, write


# The value at an address, and its change; the caller keeps the memory alive.
float64_at, put_float64 = _memory_of(types.float64)
int32_at, put_int32 = _memory_of(types.int32)
int64_at, _ = _memory_of(types.int64)

"""Makes a law callable by address: from its functions of NamedTuples to functions of six pointers.

The loop is compiled once for all laws; it calls the law at hand by its address, with pointers to gains, context (period
and limits), follower, leader, memory and result. What is compiled for each law is a wrapper between the two, whose text
is written into the cache so that the next process finds the compiled code there.
"""

from __future__ import annotations

import ctypes
import hashlib
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, get_type_hints

from nhtrack.compiled import cache_folder, compiled, compiled_for_address
from nhtrack.errors import NhtrackError
from nhtrack.laws.contract import Follower, Leader, Limits

if TYPE_CHECKING:
    from nhtrack.laws.law import LawKind

POINTERS = 6
CONTEXT = 1 + len(Limits._fields)
FAILED = 2  # place in the result that is not zero where the law raised an exception


class InterpretedLawWarning(UserWarning):
    """A law that cannot be compiled and runs as Python."""


class LawCompileError(NhtrackError):
    """A law of the package that does not compile."""


@dataclass(frozen=True)
class Entry:
    """Where the code of a law is.

    Attributes:
        init: address of what makes its memory.
        command: address of what commands.
        interpreted: why it runs as Python, or None for a compiled law.
        owner: what keeps the code in memory.
    """

    init: int
    command: int
    interpreted: str | None
    owner: Any


def entry_of(kind: LawKind) -> Entry:
    """Returns the addresses of a law; one that cannot be compiled is called as Python, and a warning says so once."""
    try:
        init, command = _compiled(kind)
        return Entry(init.address, command.address, None, (init, command))
    except Exception as error:
        if kind.built_in:
            raise LawCompileError(f"{kind.file}: {error}") from error
        reason = _reason(error)
    warnings.warn(
        f"law {kind.name!r} runs as Python, some hundred times slower than compiled: {reason}",
        InterpretedLawWarning,
        stacklevel=2,
    )
    init, command = (_SIGNATURE(_interpreted(kind, name)) for name in ("init", "command"))
    addresses = (int(ctypes.cast(function, ctypes.c_void_p).value or 0) for function in (init, command))
    return Entry(next(addresses), next(addresses), reason, (init, command))


def _reason(error: Exception) -> str:
    """Returns what the compiler did not take, in one line."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    said = [line for line in lines if not line.startswith(("Failed in", "[1]", "File "))]
    place = next((line.split(",")[1].strip() for line in lines if line.startswith("File ") and "," in line), "")
    return " ".join(said[:2])[:300] + (f" ({place})" if place else "")


def _compiled(kind: LawKind) -> tuple[Any, Any]:
    """Returns `init` and `command` of a law as compiled functions with an address."""
    text = _text(kind)
    name = f"nhtrack_law_{kind.name}_{_digest(kind, text)}"
    module = sys.modules[name] = ModuleType(name)  # what is read from the cache looks for it there
    module.__dict__.update(_space(kind))
    exec(compile(text, _file(name, text), "exec"), module.__dict__)
    return module.init_at, module.command_at


def _digest(kind: LawKind, text: str) -> str:
    return hashlib.sha256((kind.source + text).encode()).hexdigest()[:16]


def _file(name: str, text: str) -> str:
    """Returns the file that the wrapper's text is in; where there is no cache, a name that is no file."""
    folder = cache_folder("laws")
    if folder is None:
        return f"<{name}>"
    path = folder / f"{name}.py"
    if not path.exists():
        _write(path, text)
    return str(path)


def _write(path: Path, text: str) -> None:
    temporary = path.with_name(f".{path.name}.{id(text)}")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(path)


def _space(kind: LawKind) -> dict[str, Any]:
    """Returns the names that the wrapper's text uses."""
    from numba import carray

    space: dict[str, Any] = {
        "carray": carray, "Follower": Follower, "Leader": Leader,
        "Limits": Limits, "Gains": kind.gains, "for_address": compiled_for_address(POINTERS),
    }  # fmt: skip
    space["law_command"] = compiled(kind.command)
    if kind.memory is not None:
        space |= {"Memory": kind.memory, "law_init": compiled(kind.init)}  # type: ignore[type-var]
    return space


def _text(kind: LawKind) -> str:
    """Returns the text of the wrapper."""
    gains = _arguments(kind.gains, "g")
    memory = "()" if kind.memory is None else f"Memory({_arguments(kind.memory, 'm')})"
    seen = f"""    g = carray(gains, ({max(len(kind.gains._fields), 1)},))
    c = carray(context, ({CONTEXT},))
    f = carray(follower, ({len(Follower._fields)},))
    l = carray(leader, ({len(Leader._fields)},))
    m = carray(memory, ({max(kind.memory_size, 1)},))
    r = carray(result, ({FAILED + 1},))
    seen_f = Follower({_places("f", Follower)})
    seen_l = Leader({_places("l", Leader)})
    own = Gains({gains})
"""
    stored = "".join(f"    m[{i}] = kept.{name}\n" for i, name in enumerate(kind.memory._fields if kind.memory else ()))
    guarded = "" if kind.built_in else "    "
    call = f"law_command(own, c[0], Limits(c[1], c[2], c[3], c[4]), seen_f, seen_l, {memory})"
    begin, end = ("", "") if kind.built_in else ("    try:\n", "    except Exception:\n        r[2] = 1.0\n")

    def body(lines: str) -> str:
        return begin + "".join(guarded + line + "\n" for line in lines.splitlines()) + end

    init = body(f"    kept = law_init(own, c[0], seen_f, seen_l)\n{stored}") if kind.memory else ""
    command = body(f"    u_x, u_theta, kept = {call}\n    r[0] = u_x\n    r[1] = u_theta\n{stored}")
    head = "(gains, context, follower, leader, memory, result):\n"
    return f"@for_address\ndef init_at{head}{seen}{init}\n\n@for_address\ndef command_at{head}{seen}{command}"


def _places(array: str, kind: Any) -> str:
    return ", ".join(f"{array}[{i}]" for i in range(len(kind._fields)))


def _arguments(kind: Any, array: str) -> str:
    """Returns the arguments of a NamedTuple, out of an array of numbers, each as the type of its field."""
    hints = get_type_hints(kind)
    ways = {float: "{}", int: "int({})", bool: "({} != 0.0)"}
    return ", ".join(ways[hints[name]].format(f"{array}[{i}]") for i, name in enumerate(kind._fields))


# A law as Python ------------------------------------------------------------------------------------------------------

_SIGNATURE = ctypes.CFUNCTYPE(None, *(POINTERS * [ctypes.POINTER(ctypes.c_double)]))


def _interpreted(kind: LawKind, name: str) -> Callable[..., None]:
    """Returns the function of six pointers that calls a function of a law as Python."""

    def call(gains: Any, context: Any, follower: Any, leader: Any, memory: Any, result: Any) -> None:
        try:
            values = call_law(
                kind, name, gains[: len(kind.gains._fields)], context[:CONTEXT], follower[: len(Follower._fields)],
                leader[: len(Leader._fields)], memory[: kind.memory_size],
            )  # fmt: skip
            result[0], result[1] = values[:2]
            for i, value in enumerate(values[2:]):
                memory[i] = value
        except Exception:
            result[FAILED] = 1.0

    return call


def call_law(
    kind: LawKind, name: str, gains: Any, context: Any, follower: Any, leader: Any, memory: Any
) -> tuple[float, ...]:
    """Returns (u_x, u_theta, *memory) of a law called as Python; zeros for the accelerations of `init`."""
    own, seen = _typed(kind.gains, gains), (Follower(*follower), Leader(*leader))
    held: Any = () if kind.memory is None else _typed(kind.memory, memory)
    if name == "init":
        return (0.0, 0.0, *(() if kind.init is None else tuple(kind.init(own, context[0], *seen))))
    u_x, u_theta, kept = kind.command(own, context[0], Limits(*context[1:]), *seen, held)
    return (float(u_x), float(u_theta), *(float(value) for value in kept))


def _typed(kind: Any, values: Any) -> Any:
    hints = get_type_hints(kind)
    return kind(*(hints[name](value) for name, value in zip(kind._fields, values, strict=True)))

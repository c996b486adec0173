"""Makes a law callable by address: from its functions of NamedTuples to functions of six pointers.

The loop is compiled once for all laws; it calls the law at hand by its address, with pointers to gains, context (period
and limits), follower, leader, memory and result. What is compiled for each law is a wrapper between the two, whose text
is written into the cache so that the next process finds the compiled code there.
"""

from __future__ import annotations

import ctypes
import hashlib
import re
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from multiprocessing import parent_process
from pathlib import Path
from types import ModuleType
from typing import Any

from nhtrack.compiled import WRAPPERS, cache_folder, compiled, compiled_for_address
from nhtrack.errors import NhtrackError
from nhtrack.files.atomic import atomic_path
from nhtrack.laws.contract import Follower, Leader, Limits
from nhtrack.laws.functions import as_compiled, python_of, texts_reached
from nhtrack.laws.law import LawKind
from nhtrack.laws.slots import Slot, flattened, packed, slots_of

POINTERS = 6
CONTEXT = 1 + len(Limits._fields)
SLOWER = "each call some 250 times slower than compiled"  # measured: 110 to 450 for the laws of the package
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


@cache
def entry_of(kind: LawKind) -> Entry:
    """Returns the addresses of a law; one that cannot be compiled is called as Python, and a warning says so once."""
    try:
        init, command = _compiled(kind)
        return Entry(init.address, command.address, None, (init, command))
    except Exception as error:
        if kind.built_in:
            raise LawCompileError(f"{kind.file}: {error}") from error
        reason = _reason(error, kind)
    if parent_process() is None:  # else a worker, of a process that has said so
        warnings.warn(f"law {kind.name!r} {runs_as_python(reason)}", InterpretedLawWarning, stacklevel=2)
    init, command = (_SIGNATURE(_interpreted(kind, name)) for name in ("init", "command"))
    addresses = (int(ctypes.cast(function, ctypes.c_void_p).value or 0) for function in (init, command))
    return Entry(next(addresses), next(addresses), reason, (init, command))


def runs_as_python(reason: str) -> str:
    """Returns what to say of a law that cannot be compiled."""
    return f"runs as Python, {SLOWER}: {reason}"


def _reason(error: Exception, kind: LawKind) -> str:
    """Returns what the compiler did not take, in one line, with the line of the law's file."""
    text = _COLOUR.sub("", str(error))
    lines = [" ".join(line.split()) for line in text.splitlines()]
    first = next((i for i, line in enumerate(lines) if line and not line.startswith(_NOISE)), 0)
    said = lines[first] if lines else type(error).__name__
    if said.endswith(":"):  # what it is about stands below
        said += " " + next((line for line in lines[first + 1 :] if line), "")
    name = re.escape(Path(kind.file).name)
    numbers = [a or b for a, b in re.findall(rf'{name}"?, line (\d+)|{name} \((\d+)\)', text)]
    return said.partition(" Raised from ")[0][:200] + (f" ({kind.file}:{numbers[-1]})" if numbers else "")


_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_NOISE = ("Failed in", "[1]", "File ", "-", "During:", "Enable logging", "There are")


def _compiled(kind: LawKind) -> tuple[Any, Any]:
    """Returns `init` and `command` of a law as compiled functions with an address."""
    text = _text(kind)
    name = f"{WRAPPERS}{kind.name}_{_digest(kind, text)}"
    module = sys.modules[name] = ModuleType(name)  # what is read from the cache looks for it there
    module.__dict__.update(_space(kind))
    exec(compile(text, _file(name, text), "exec"), module.__dict__)
    return module.init_at, module.command_at


def _digest(kind: LawKind, text: str) -> str:
    """Returns a hash of all that the code of a law is made of, but for the package's own."""
    home = _home(kind)  # code in the cache looks for the law's module by its name
    reached = [] if kind.built_in else [str(home.get("__name__")), *texts_reached(home)]
    return hashlib.sha256("\0".join([kind.source, text, *reached]).encode()).hexdigest()[:16]


def _home(kind: LawKind) -> dict[str, Any]:
    """Returns the names of a law's file."""
    plain = python_of(kind.command)
    return {} if plain is None else plain.__globals__


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
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _space(kind: LawKind) -> dict[str, Any]:
    """Returns the names that the wrapper's text uses."""
    from numba import carray

    space: dict[str, Any] = {
        "carray": carray, "Follower": Follower, "Leader": Leader,
        "Limits": Limits, "Gains": kind.gains, "for_address": compiled_for_address(POINTERS),
    }  # fmt: skip
    space |= {f"law_{name}": function for name, function in _functions(kind).items()}
    return space if kind.memory is None else space | {"Memory": kind.memory}


def _functions(kind: LawKind) -> dict[str, Any]:
    """Returns `command`, and `init` of a law with memory, to be compiled when they are first called."""
    found: dict[str, Any] = {"command": kind.command} | ({} if kind.memory is None else {"init": kind.init})
    if not kind.built_in:
        home = as_compiled(_home(kind))
        found = {name: home.get(name, function) for name, function in found.items()}
    return {name: compiled(each) if _is_plain(each) else each for name, each in found.items()}


def _is_plain(function: Any) -> bool:
    return python_of(function) is function


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
    slots = () if kind.memory is None else slots_of(kind.memory)
    stored = "".join(f"    m[{i}] = kept{_access(slot)}\n" for i, slot in enumerate(slots))
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
    """Returns the arguments of a NamedTuple, out of an array of numbers, each as the type of its place."""
    ways = {float: "{}", int: "int({})", bool: "({} != 0.0)"}
    fields: dict[str, str] = {}
    for i, slot in enumerate(slots_of(kind)):
        number = ways[slot.kind].format(f"{array}[{i}]")
        before = fields.get(slot.field, "(")
        fields[slot.field] = number if slot.item < 0 else f"{before.removesuffix(')')}{number},)"
    return ", ".join(fields.values())


def _access(slot: Slot) -> str:
    return f".{slot.field}" if slot.item < 0 else f".{slot.field}[{slot.item}]"


# A law as Python ------------------------------------------------------------------------------------------------------

_SIGNATURE = ctypes.CFUNCTYPE(None, *(POINTERS * [ctypes.POINTER(ctypes.c_double)]))
_interruptions: list[str] = []  # functions that were stopped and could not say so


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
        except KeyboardInterrupt:  # machine code, which called, would lose it
            result[FAILED] = 1.0
            _interruptions.append(name)

    return call


def require_uninterrupted() -> None:
    """Raises, once the compiled code is back that called a law as Python, where the user has stopped that.

    Raises:
        KeyboardInterrupt: the user has.
    """
    if _interruptions:
        _interruptions.clear()
        raise KeyboardInterrupt


def call_law(
    kind: LawKind, name: str, gains: Any, context: Any, follower: Any, leader: Any, memory: Any
) -> tuple[float, ...]:
    """Returns (u_x, u_theta, *memory) of a law called as Python; zeros for the accelerations of `init`."""
    own, seen = packed(kind.gains, gains), (Follower(*follower), Leader(*leader))
    if name == "init":
        return (0.0, 0.0, *(flattened(kind.python[name](own, context[0], *seen)) if kind.memory is not None else ()))
    held: Any = () if kind.memory is None else packed(kind.memory, memory)
    u_x, u_theta, kept = kind.python[name](own, context[0], Limits(*context[1:]), *seen, held)
    return (float(u_x), float(u_theta), *flattened(kept))

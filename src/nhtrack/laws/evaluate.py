"""A law asked for many followers at once, outside any run: for tests, maps of commands, and figures."""

from __future__ import annotations

import numpy as np

from nhtrack.compiled import call_6, compiled
from nhtrack.laws.address import FAILED, call_law, entry_of
from nhtrack.laws.contract import Follower, Leader
from nhtrack.laws.law import Law


def first_memories(law: Law, follower: np.ndarray, leader: np.ndarray, period: float = 0.01) -> np.ndarray:
    """Returns what followers remember at the start, shape (k, values).

    Args:
        law: what they obey.
        follower: rows as `Follower`, shape (k, 6).
        leader: rows as `Leader`, shape (k, 9).
        period: control period [s].

    Raises:
        Exception: what the law itself raises.
    """
    memory = np.zeros((len(follower), law.kind.memory_size))
    _ask(law, "init", follower, leader, memory, period)
    return memory


def commands(
    law: Law, follower: np.ndarray, leader: np.ndarray, memory: np.ndarray, period: float = 0.01
) -> tuple[np.ndarray, np.ndarray]:
    """Returns accelerations (u_x, u_theta), shape (k, 2), and memories, shape (k, values); see `first_memories`.

    Args:
        law: what followers obey; with gains of shape (k,) each has its own.
        follower: rows as `Follower`, shape (k, 6).
        leader: rows as `Leader`, shape (k, 9).
        memory: of the last call, shape (k, values).
        period: control period [s].
    """
    after = np.array(memory, dtype=float)
    return _ask(law, "command", follower, leader, after, period), after


def _ask(
    law: Law, function: str, follower: np.ndarray, leader: np.ndarray, memory: np.ndarray, period: float
) -> np.ndarray:
    """Calls a function of a law for every follower; memories are changed in place."""
    seen = np.ascontiguousarray(follower, dtype=float).reshape(-1, len(Follower._fields))
    tracked = np.ascontiguousarray(leader, dtype=float).reshape(-1, len(Leader._fields))
    held = memory if memory.shape[1] else np.zeros((len(memory), 1))
    context, gains = np.array([period, *law.limits], dtype=float), law.gain_rows
    u = np.zeros((len(seen), FAILED + 1))
    failed = ask_all(getattr(entry_of(law.kind), function), gains, context, seen, tracked, held, u)
    if failed >= 0:
        own = gains[failed if len(gains) > 1 else 0]
        call_law(law.kind, function, own, context, seen[failed], tracked[failed], memory[failed])
        raise RuntimeError(f"law {law.kind.name!r} raised an exception as compiled code, but none as Python")
    return u[:, :2]


@compiled
def ask_all(
    address: int, gains: np.ndarray, context: np.ndarray, follower: np.ndarray, leader: np.ndarray,
    memory: np.ndarray, result: np.ndarray,
) -> int:  # fmt: skip
    """Calls a law by its address row by row; returns the first row in which it raised, or -1."""
    for k in range(follower.shape[0]):
        call_6(
            address,
            gains[k if gains.shape[0] > 1 else 0].ctypes.data,
            context.ctypes.data,
            follower[k].ctypes.data,
            leader[k].ctypes.data,
            memory[k].ctypes.data,
            result[k].ctypes.data,
        )
        if result[k, 2] != 0.0:
            return k
    return -1

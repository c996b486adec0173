"""Prints what a command of each law costs, compiled, and what compiling it takes: python benchmarks/laws.py."""

from __future__ import annotations

import time

import numpy as np

from nhtrack.laws import laws
from nhtrack.laws.evaluate import commands, first_memories

COUNT, SPELLS = 20_000, 7


def main() -> None:
    rng = np.random.default_rng(0)
    follower, leader = rng.normal(size=(COUNT, 6)), rng.normal(size=(COUNT, 9))
    print("law                       command [ns]  ready [s]")
    for name, kind in laws().items():
        law = kind(**{gain: kind.gains._field_defaults.get(gain, 2.0) for gain in kind.gains._fields})
        begin = time.process_time()
        memory = first_memories(law, follower, leader)
        ready = time.process_time() - begin
        spent = np.inf
        for _ in range(SPELLS):
            begin = time.process_time()
            commands(law, follower, leader, memory)
            spent = min(spent, time.process_time() - begin)
        print(f"{name:25s} {1e9 * spent / COUNT:12.0f}  {ready:9.2f}", flush=True)


if __name__ == "__main__":
    main()

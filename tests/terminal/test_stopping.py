"""What asks a program to end is heard, wherever it comes."""

from __future__ import annotations

import subprocess
import sys

import pytest

_ASKED = """\
import signal, sys, time, weakref
from nhtrack.terminal.stopping import comes_of_interruption, listen

listen()

class Thing:
    pass

def stop(_):
    signal.raise_signal(signal.{how})

thing = Thing()
if {lost}:
    kept = weakref.ref(thing, stop)
try:
    del thing
    assert {lost} == comes_of_interruption(ValueError())
    if not {lost}:
        stop(None)
    time.sleep(60)
except KeyboardInterrupt:
    assert not comes_of_interruption(None)
    try:
        raise ImportError("initialization failed")
    except ImportError as made_of_it:
        print("heard" if comes_of_interruption(made_of_it) else "taken for something else")
"""


@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "SIGHUP"])
@pytest.mark.parametrize("lost", [False, True])
def test_what_asks_to_end_is_heard_even_where_python_ignores_what_is_raised(how: str, lost: bool) -> None:
    script = [sys.executable, "-c", _ASKED.format(how=how, lost=lost)]
    done = subprocess.run(script, capture_output=True, text=True, timeout=30)
    assert (done.stdout, done.stderr) == ("heard\n", "")

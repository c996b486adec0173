"""What asks a program to end is heard, wherever it comes, and cuts short nothing that tidies up."""

from __future__ import annotations

import subprocess
import sys

import pytest

_ASKED = """\
import signal, sys, time, weakref
from nhtrack.stopping import comes_of_interruption, end_at_once, heard, listen

signal.signal(signal.{how}, signal.SIG_DFL)  # a test may be run where it is ignored
listen()

class Thing:
    pass

def stop(*_):
    signal.raise_signal(signal.{how})

def finaliser():
    thing = Thing()
    kept = weakref.ref(thing, stop)
    del thing

def module():
    try:
        stop()
    except BaseException:
        pass

def library():
    try:
        stop()
    except BaseException:
        raise ImportError("initialization failed") from None

def generator():
    try:
        yield
    finally:
        time.sleep(0.3)
        tidied.append("generator")

def closed():
    for _ in generator():
        stop()

tidied = []
try:
    try:
        {lost}()
        assert comes_of_interruption(ValueError())
        time.sleep(60)
    finally:
        time.sleep(0.3)
        tidied.append("all")
except BaseException as error:
    assert comes_of_interruption(error)
    heard()
    assert not comes_of_interruption(ValueError())
time.sleep(0.3)
print(*tidied)
sys.stdout.flush()
end_at_once()
stop()
print("and goes on")
"""


_LOST = ["finaliser", "module", "library", "closed"]


@pytest.mark.parametrize(
    ("how", "lost"), [*(("SIGINT", lost) for lost in _LOST), ("SIGTERM", "stop"), ("SIGHUP", "stop")]
)
def test_what_asks_to_end_comes_again_until_heard_but_cuts_short_nothing_that_tidies_up(how: str, lost: str) -> None:
    script = [sys.executable, "-c", _ASKED.format(how=how, lost=lost)]
    done = subprocess.run(script, capture_output=True, text=True, timeout=30)
    assert (done.stdout, done.stderr) == ("generator all\n" if lost == "closed" else "all\n", "")
    assert done.returncode < 0

"""What asks the program to end, be it Ctrl-C, SIGTERM or a terminal that is closed, as KeyboardInterrupt.

An exception can be lost: modules swallow it while they are imported, Python what is raised in finalisers and callbacks.
So it is raised again until `heard` is called, but not while one is being dealt with: nothing cuts short what tidies up.
"""

from __future__ import annotations

import signal
import subprocess
import sys
from types import FrameType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

__all__ = ["ASKING", "comes_of_interruption", "end_at_once", "heard", "listen"]

_AGAIN = signal.SIGALRM  # asks anew
ASKING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, _AGAIN)
_INTERVAL = 0.2  # [s] after which an interruption that nobody has heard comes again
_SOON = 0.01  # [s], where the first could not be raised
_STARTING = (subprocess.Popen.__init__.__code__, subprocess.Popen._execute_child.__code__)  # type: ignore[attr-defined]
_asked = False  # and not heard


def listen() -> None:
    """Lets whatever asks this process to end interrupt it; what it was begun to ignore (nohup) it ignores still."""
    for number in ASKING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _interrupt)
    sys.unraisablehook = _tell_of_others


def heard() -> None:
    """Says that an interruption has been caught where it should be, and is not to come again; without one, nothing."""
    global _asked
    if _asked:
        _asked = False
        signal.setitimer(signal.ITIMER_REAL, 0)


def end_at_once() -> None:
    """Lets what asks this process to end do so without more ado, since there is nothing left to tidy up."""
    heard()
    for number in ASKING:
        if signal.getsignal(number) is _interrupt:
            signal.signal(number, signal.SIG_DFL)


def comes_of_interruption(error: BaseException | None) -> bool:
    """Returns whether an error is an interruption, or was made of one, such as of one that has not been heard."""
    return _asked or _follows(error, KeyboardInterrupt)


def _follows(error: BaseException | None, *kinds: type[BaseException]) -> bool:
    while error is not None and not isinstance(error, kinds):
        error = error.__cause__ or error.__context__
    return error is not None


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raises KeyboardInterrupt, a little later while a process is being started, which nobody would end."""
    global _asked
    if number == _AGAIN and not _asked:
        return  # it has been heard meanwhile
    _asked = True
    starting = frame is not None and frame.f_code in _STARTING
    signal.setitimer(signal.ITIMER_REAL, _SOON if starting else _INTERVAL)
    if starting or (number == _AGAIN and _follows(sys.exception(), KeyboardInterrupt, GeneratorExit)):
        return  # what tidies up may be a generator that is closed on the way
    raise KeyboardInterrupt


def _tell_of_others(unraisable: UnraisableHookArgs) -> None:
    """Tells what finalisers and C's callbacks raise, after which Python goes on; an interruption comes again."""
    if not issubclass(unraisable.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)

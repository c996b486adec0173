"""What asks the program to end, be it Ctrl-C, SIGTERM or a terminal that is closed, as KeyboardInterrupt."""

from __future__ import annotations

import signal
import subprocess
import sys
from types import FrameType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

__all__ = ["comes_of_interruption", "listen"]

_AGAIN = signal.SIGALRM  # what interrupts where the first could not
_ASKING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, _AGAIN)
_LATER = 0.01  # [s] when an interruption is tried again
_STARTING = (subprocess.Popen.__init__.__code__, subprocess.Popen._execute_child.__code__)  # type: ignore[attr-defined]
_lost = False


def listen() -> None:
    """Lets whatever asks this process to end interrupt it; what it was begun to ignore (nohup) it ignores still."""
    for number in _ASKING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _interrupt)
    sys.unraisablehook = _interrupt_again


def comes_of_interruption(error: BaseException | None) -> bool:
    """Returns whether an error is an interruption, or what machine code made of one or of one that it lost."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return _lost or error is not None


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raises KeyboardInterrupt, a little later while a process is being started, which nobody would end."""
    global _lost
    if frame is not None and frame.f_code in _STARTING:
        signal.setitimer(signal.ITIMER_REAL, _LATER)
        return
    _lost = False
    raise KeyboardInterrupt


def _interrupt_again(unraisable: UnraisableHookArgs) -> None:
    """Interrupts a little later where that was lost: Python goes on after what finalisers and C's callbacks raise."""
    global _lost
    if not issubclass(unraisable.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)
        return
    _lost = True
    signal.setitimer(signal.ITIMER_REAL, _LATER)

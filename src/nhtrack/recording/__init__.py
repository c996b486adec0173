"""What a run leaves behind: a dataset with names, units and all that repeats the run."""

from nhtrack.recording.making import make_recording
from nhtrack.recording.recording import Recording
from nhtrack.recording.variables import COMPONENTS, FORMAT_VERSION, VARIABLES

__all__ = ["COMPONENTS", "FORMAT_VERSION", "VARIABLES", "Recording", "make_recording"]

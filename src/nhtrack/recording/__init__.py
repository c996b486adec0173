"""What a run leaves behind: a dataset with names, units and all that repeats the run."""

from nhtrack.recording.recording import FORMAT_VERSION, Recording, make_recording
from nhtrack.recording.variables import COMPONENTS, VARIABLES

__all__ = ["COMPONENTS", "FORMAT_VERSION", "VARIABLES", "Recording", "make_recording"]

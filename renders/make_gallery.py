"""Makes the films of renders/gallery anew, from their scenarios, and says how large they are.

    python renders/make_gallery.py [NAME ...]

Every film is a run on wheels. The pictures depend on the OpenGL that draws them, the runs do not.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from nhtrack.experiment.load import load
from nhtrack.recording import Recording
from nhtrack.studies.compare.laws_file import load_laws
from nhtrack.studies.compare.result import room_of
from nhtrack.studies.compare.run import compare_laws
from nhtrack.studies.run.run import run
from nhtrack.video import render_film
from nhtrack.video.together import together

FOLDER = Path(__file__).parent / "gallery"
MOST = 8_000_000  # bytes, all films together: they are kept in the repository
FRAMES_PER_SECOND = 10


@dataclass(frozen=True)
class Film:
    """How one film of the gallery is made.

    Attributes:
        scenario: a bundled scenario.
        camera: see `nhtrack.video.render_film`.
        seconds: how long the film is.
        size: width and height [pixels].
        rivals: laws that drive beside the scenario's own.
    """

    scenario: str
    camera: str = "isometric"
    seconds: float = 7.0
    size: tuple[int, int] = (480, 360)
    rivals: tuple[str, ...] = ()


FILMS = {
    "ice_patch": Film("stress/ice_patch", "group", 6.0, (480, 320)),
    "laws": Film("tour/universal", "group", 6.0, (400, 300), ("{name: published, kp: 1, kd: 2.5, ke: 0.5, k: 5}",)),
    "formation64": Film("stress/formation64"),
    "example1": Film("paper/example1"),
    "example2": Film("paper/example2"),
    "example3": Film("paper/example3_pi"),
    "example4": Film("paper/example4"),
    "example5": Film("paper/example5"),
}


def make(name: str) -> Path:
    """Runs a film's scenario and renders it."""
    film = FILMS[name]
    recording = _compared(film) if film.rivals else run(film.scenario).recording
    speed = float(recording.time[-1]) / film.seconds
    return render_film(
        recording, FOLDER / f"{name}.gif", camera=film.camera, size=film.size, fps=FRAMES_PER_SECOND, speed=speed,
        quality="high", processes=os.cpu_count() or 1,
    )  # fmt: skip


def _compared(film: Film) -> Recording:
    """Returns a run in which the followers of all laws drive together."""
    scenario, laws = load_laws(lambda: load(film.scenario), list(film.rivals), load)
    with tempfile.TemporaryDirectory() as folder:
        found = compare_laws(scenario, laws, Path(folder) / "runs", figures=False, video=False, report=False)
        return together(found.recordings, room_of(list(found.recordings.values())))


def main() -> None:
    """Makes the films named on the command line, or all."""
    names = sys.argv[1:] or list(FILMS)
    unknown = sorted(set(names) - set(FILMS))
    if unknown:
        sys.exit(f"no film {', '.join(unknown)}; available: {', '.join(FILMS)}")
    if names == list(FILMS):
        shutil.rmtree(FOLDER, ignore_errors=True)  # a film that is no longer made goes, too
    for name in names:
        path = make(name)
        print(f"{path.name:16} {path.stat().st_size / 1e6:5.2f} MB", flush=True)
    total = sum(path.stat().st_size for path in FOLDER.iterdir())
    print(f"{'all':16} {total / 1e6:5.2f} MB")
    if total > MOST:
        sys.exit(f"the gallery is larger than {MOST / 1e6:g} MB")


if __name__ == "__main__":
    main()

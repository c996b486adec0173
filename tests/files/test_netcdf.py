"""A netCDF file of somebody else reads no other file, and nothing that is not in it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from nhtrack.errors import RecordingError
from nhtrack.recording import Recording
from nhtrack.references.columns import FileFaults
from nhtrack.references.recorded import read_poses
from random_recording import SOME, sample

Hurt = Callable[[h5py.File], object]


def instead(name: str, **how: object) -> Hurt:
    """Returns what puts another variable into the place of one, its dimensions and attributes as they were."""

    def hurt(file: h5py.File) -> None:
        attributes = dict(file[name].attrs)
        del file[name]
        file.create_dataset(name, **how)
        for key in ("_Netcdf4Dimid", "_Netcdf4Coordinates", "DIMENSION_LIST", "CLASS", "NAME"):
            if key in attributes:
                file[name].attrs[key] = attributes[key]

    return hurt


def elsewhere(file: h5py.File) -> None:
    layout = h5py.VirtualLayout(shape=(5, 2, 3), dtype="f8")
    layout[:] = h5py.VirtualSource("other.nc", "pose", shape=(5, 2, 3))
    del file["pose"]
    file.create_virtual_dataset("pose", layout)


def link(to: object) -> Hurt:
    def hurt(file: h5py.File) -> None:
        file["pose2"] = to

    return hurt


def one_for_many(file: h5py.File) -> None:
    """Lets many names be the same long text, which is in the file once."""
    instead("robot", data=["a" * 50_000] + ["b"] * 99, dtype=h5py.string_dtype())(file)
    file.flush()
    place = file["robot"].id.get_offset()
    with open(file.filename, "r+b") as raw:
        raw.seek(place)
        first = raw.read(16)
        raw.seek(place)
        raw.write(100 * first)


def many(of: Callable[[h5py.File], Callable[..., object]]) -> Hurt:
    return lambda file: [of(file)(f"x{i}", data=0) for i in range(1001)]


POSES = {"shape": (10**6, 2, 3), "dtype": "f8"}
HURTS: dict[str, tuple[Hurt, str]] = {
    "a link to another file": (link(h5py.ExternalLink("/etc/hostname", "/")), "pose2: a link to elsewhere"),
    "a soft link": (link(h5py.SoftLink("/pose")), "pose2: a link to elsewhere"),
    "numbers of another file": (
        instead("pose", shape=(5, 2, 3), dtype="f8", external=[("/etc/passwd", 0, 240)]), "pose: lies in other files",
    ),
    "a view of another file": (elsewhere, "pose: lies in other files"),
    "rows that are not there": (instead("pose", **POSES, chunks=(1000, 2, 3)), "pose: claims 48000000 bytes"),
    "times that are not there": (instead("time", shape=(10**6,), dtype="f8"), "time: claims 8000000 bytes"),
    "an endless dimension": (instead("time", shape=(2**62,), dtype="i1", chunks=(4096,)), "time: is longer than"),
    "a huge chunk": (instead("pose", shape=(5, 2, 3), dtype="f8", maxshape=(None, 2, 3), chunks=(8 * 10**6, 2, 3),
                             compression=9), "pose: is to be read by more than"),
    "a filter that makes much of nothing": (
        instead("pose", data=np.ones((5, 2, 3), "i4"), chunks=(5, 2, 3), scaleoffset=0), "pose: is compressed by",
    ),
    "lists of lists": (instead("pose", shape=(5, 2, 3), dtype=h5py.vlen_dtype("f8")), "pose: neither numbers nor"),
    "records": (instead("pose", shape=(5, 2, 3), dtype=[("x", "f8")]), "pose: neither numbers nor text"),
    "long names": (instead("robot", shape=(2,), dtype=f"S{10**9}", chunks=(1,)), "robot: claims 2000000000 bytes"),
    "many names": (instead("robot", data=[b"a"] * 60_000, dtype=h5py.string_dtype()), "robot: 60000 texts"),
    "a type for a variable": (lambda file: file.__setitem__("kind", np.dtype("f8")), "kind: no variable"),
    "one name for many": (one_for_many, "robot: its texts are longer than the file"),
    "many variables": (many(lambda file: file.create_dataset), "variables, more than 1000"),
    "many attributes": (many(lambda file: file["pose"].attrs.create), "attributes, more than 1000"),
    "attributes of many parts": (lambda file: file.attrs.create("x", ["a"] * 99), "attribute 'x' has more"),
}  # fmt: skip


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return sample(names=SOME).save(tmp_path_factory.mktemp("sound") / "recording.nc").read_bytes()


@pytest.mark.parametrize("hurt", HURTS)
def test_what_was_made_to_hurt_is_told(hurt: str, sound: bytes, tmp_path: Path) -> None:
    change, said = HURTS[hurt]
    file = tmp_path / "recording.nc"
    file.write_bytes(sound)
    with h5py.File(file, "r+") as opened:
        change(opened)
    with pytest.raises(RecordingError, match=f"recording.nc: not a recording .*{said}"):
        Recording.load(file)
    with pytest.raises(FileFaults, match=said):
        read_poses(file, "follower")

"""A netCDF file that is written as its rows come, whatever happens to the disk or to the process meanwhile."""

from __future__ import annotations

import io
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nhtrack.arrays import CHUNK
from nhtrack.errors import WriteError
from nhtrack.files.atomic import reason_of
from nhtrack.files.checksums import CHECKSUMS, checksum_of, checksum_of_meaning, checksum_of_rows, noted

if TYPE_CHECKING:
    import xarray as xr

ROWS = "time"  # the dimension along which rows are added
_ROBOTS = 8  # in a chunk: who reads one of many robots reads few others


class AppendedDataset:
    """A dataset in a file, to which rows are added.

    A thread of its own writes: an exception that a signal raises, in the main thread, leaves no half-written row.
    """

    def __init__(self, file: Path, template: xr.Dataset, chunk: int = CHUNK) -> None:
        """Makes the file.

        Args:
            file: which has no row yet.
            template: what it is to hold, of no row: variables, coordinates, what is known of them.
            chunk: rows that are compressed, and read, together.
        """
        import h5netcdf

        self._rows, self._pending, self._pool = 0, Future[None](), ThreadPoolExecutor(1)
        self._pending.set_result(None)
        self._growing = [str(name) for name, variable in template.variables.items() if ROWS in variable.dims]
        self._template, self._sums = template, dict.fromkeys(self._growing, 0)
        encoding = {name: _encoding(template[name], chunk) for name in self._growing}
        skeleton = template.drop_attrs(deep=False)
        file.write_bytes(skeleton.to_netcdf(engine="h5netcdf", encoding=encoding, unlimited_dims=[ROWS]))
        self._file = _Patient(file)
        self._dataset = h5netcdf.File(self._file, "r+")

    def append(self, first: int, values: Mapping[str, np.ndarray]) -> None:
        """Hands rows over, which must not change before the next call of any method; those it has it does not take.

        Args:
            first: the number of the first of them.
            values: by the names of variables, shape (k, ...).

        Raises:
            WriteError: rows before these could not be written.
        """
        self.wait()
        self._pending = self._pool.submit(self._write, first, values)

    def wait(self) -> None:
        """Returns when all rows have been written.

        Raises:
            WriteError: they could not be.
        """
        self._pending.result()

    def __getitem__(self, name: str) -> Any:
        """Returns what is read as an array, a part at a time, of the rows of a variable."""
        self.wait()
        return self._dataset[name]

    def finish(self, attributes: Mapping[str, Any]) -> None:
        """Writes the attributes of the dataset, with the checksums, and closes the file.

        Raises:
            WriteError: the file could not be written.
        """
        self.wait()
        found = {
            str(name): checksum_of_meaning(each.attrs, each.dims, self._dataset[name].shape, self._sums[str(name)])
            if name in self._sums
            else checksum_of(each)
            for name, each in self._template.variables.items()
        }
        self._pool.submit(self._close, {**attributes, CHECKSUMS: noted(found, attributes)}).result()

    def discard(self) -> None:
        """Closes a file that nobody needs any more."""
        self._pool.shutdown(wait=True)
        self._file.error = self._file.error or OSError("discarded")  # nothing is written any more
        with suppress(OSError, RuntimeError):  # of what could not be written HDF5 reads nothing back
            self._dataset.close()
        self._file.close()

    def _write(self, first: int, values: Mapping[str, np.ndarray]) -> None:
        if first != self._rows:  # who was interrupted does not know whether it has handed them over
            return
        self._rows += len(values[ROWS])
        try:
            self._dataset.resize_dimension(ROWS, self._rows)
            for name in self._growing:
                self._dataset[name][first : self._rows] = values[name]
                self._sums[name] = checksum_of_rows(values[name], self._sums[name])
        finally:
            self._file.require_written()

    def _close(self, attributes: Mapping[str, Any]) -> None:
        try:
            for name, value in attributes.items():
                self._dataset.attrs[name] = value
            self._dataset.close()
            self._file.close()
        finally:
            self._file.require_written()


class _Patient(io.FileIO):
    """A file that remembers that it could not be written instead of saying so: HDF5 does not survive a full disk."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, "r+")
        self.error: OSError | None = None

    def write(self, data: Any) -> int:
        """Writes all of some bytes, or remembers why not."""
        size, done = len(view := memoryview(data).cast("B")), 0
        while done < size and self.error is None:
            try:
                done += super().write(view[done:]) or 0
            except OSError as error:
                self.error = error
        return size

    def truncate(self, size: int | None = None) -> int:
        """Cuts the file, or makes it longer; or remembers why not."""
        try:
            return super().truncate(size)
        except OSError as error:
            self.error = self.error or error
            return size or 0

    def flush(self) -> None:
        """Does nothing: all is written at once."""

    def require_written(self) -> None:
        """Raises what kept the file from being written, if anything did."""
        if self.error is not None:
            raise WriteError(f"cannot write {self.name}: {reason_of(self.error)}")


def _encoding(variable: xr.DataArray, chunk: int) -> dict[str, Any]:
    sizes = dict(variable.sizes) | {ROWS: chunk}
    cut = {"robot": _ROBOTS}
    chunks = tuple(max(1, min(size, cut.get(str(dim), size))) for dim, size in sizes.items())
    packed: dict[str, Any] = {"zlib": True, "complevel": 4, "shuffle": True}
    return {"chunksizes": chunks, "_FillValue": None} | (packed if variable.ndim > 1 else {})

"""The results: a folder of Parquet files. Each row has its place in one file by its path, and a file is replaced as a
whole, so that at every moment each result is there once or not at all."""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import os
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from .jobs import BadInput, Job
from .work import Row

PARTS = 64
#: Seconds after which results are written though their file is not complete.
INTERVAL = 10.0

PARAMETER = pa.struct(
    [("name", pa.string()), ("unit", pa.string()), ("nominal", pa.float64()), ("value", pa.float64())]
    + [("ci95", pa.float64()), ("identifiable", pa.bool_()), ("at_bound", pa.bool_()), ("word", pa.string())]
)
CAUSE = pa.struct(
    [("effect", pa.string()), ("site", pa.string()), ("probability", pa.float64()), ("shrinkage", pa.float64())]
)
DIAGNOSTIC = pa.struct(
    [(name, pa.string()) for name in ("code", "severity", "message", "remedy", "file")]
    + [("line", pa.int64()), ("column", pa.int64())]
)
SCHEMA = pa.schema(
    [(name, pa.string()) for name in ("path", "command", "settings", "version", "hash", "status")]
    + [("exit_status", pa.int8()), ("verdict", pa.string()), ("unit", pa.string())]
    + [(name, pa.float64()) for name in ("before", "registration", "after")]
    + [("causes", pa.list_(CAUSE)), ("parameters", pa.list_(PARAMETER))]
    + [
        ("seconds", pa.float64()),
        ("error", pa.string()),
        ("diagnostics", pa.list_(DIAGNOSTIC)),
        ("json", pa.large_string()),
    ]
)
KEY = ["path", "command", "settings"]


def part(path: str) -> int:
    """The file in which a campaign's rows are."""
    return int.from_bytes(hashlib.sha256(path.encode("utf-8", "surrogatepass")).digest()[:2], "big") % PARTS


class Dataset:
    """A folder of results, of which this process is the only writer."""

    def __init__(self, folder: str) -> None:
        self.folder = Path(folder)
        self._rows: dict[int, dict[tuple[str, str, str], Row]] = {}
        self._written = time.monotonic()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            self._lock = (self.folder / ".lock").open("w")
            _lock(self._lock)
            for left in self.folder.glob(".part-*.tmp"):
                left.unlink()
        except OSError as error:
            raise BadInput(f"results cannot be written into `{folder}`: {error.strerror or error}") from None
        self._there = self._read()

    def _read(self) -> dict[tuple[str, str, str], tuple[str, str, str, str | None]]:
        there: dict[tuple[str, str, str], tuple[str, str, str, str | None]] = {}
        for file in sorted(self.folder.glob("part-*.parquet")):
            try:
                table = pq.read_table(file, columns=[*KEY, "version", "hash", "status", "error"])
            except (OSError, pa.ArrowException, KeyError) as error:
                raise BadInput(f"`{file}` holds no results of a fleet: {error}") from None
            for path, command, settings, *rest in zip(*(column.to_pylist() for column in table.columns)):
                version, hash_, status, why = rest
                there[(path, command, settings)] = (version, hash_, status, why)
        return there

    def status(self, job: Job, version: str) -> str | None:
        """How the job ended, if its result is here: of the same files, settings and version, and not lost."""
        held = self._there.get(job.key)
        return held[2] if held is not None and held[:2] == (version, job.hash) and held[2] != "lost" else None

    def errors(self, jobs: Iterable[Job]) -> dict[Job, str]:
        """What was wrong with those whose result tells."""
        held = {job: self._there[job.key][3] for job in jobs if job.key in self._there}
        return {job: error for job, error in held.items() if error}

    def add(self, row: Row) -> None:
        """Takes a result; it is written with others of its file."""
        self._rows.setdefault(part(row["path"]), {})[(row["path"], row["command"], row["settings"])] = row

    def write(self, complete: Iterable[int] = ()) -> None:
        """Writes the files that are complete, and after a while all."""
        if time.monotonic() - self._written > INTERVAL:
            self.write_all()
        for each in complete:
            self._replace(each)

    def write_all(self) -> None:
        """Writes what is not written yet."""
        for each in sorted(self._rows):
            self._replace(each)
        self._written = time.monotonic()

    def _replace(self, number: int) -> None:
        rows = self._rows.get(number)
        if not rows:
            return
        whole = {name: [row.get(name) for row in rows.values()] for name in SCHEMA.names}
        table = pa.table(whole, schema=SCHEMA)
        file = self.folder / f"part-{number:02}.parquet"
        if file.exists():
            old = pq.read_table(file)
            keys = zip(*(old[name].to_pylist() for name in KEY))
            table = pa.concat_tables(
                [table, old.filter(pa.array([key not in rows for key in keys], pa.bool_()))], promote_options="default"
            )
        table = table.sort_by([(name, "ascending") for name in KEY])
        temporary = self.folder / f".part-{number:02}.tmp"
        with temporary.open("wb") as out:
            pq.write_table(table, out, compression="zstd")
            out.flush()
            os.fsync(out.fileno())
        os.replace(temporary, file)
        for key, row in self._rows.pop(number).items():
            self._there[key] = (row["version"], row["hash"], row["status"], row.get("error"))

    def close(self) -> None:
        """Lets others write."""
        self._lock.close()


def _lock(file: Any) -> None:
    """Refuses a folder into which another run writes. Where files cannot be locked, nothing is refused."""
    with contextlib.suppress(ImportError):
        fcntl = importlib.import_module("fcntl")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OSError("another run writes there") from None

"""One job as a row of the dataset. It is a function of the job and its files alone: it may run anywhere, and again."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import socket
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .. import Error, _native
from ..results import judged
from .jobs import Job, truth

Row = dict[str, Any]


def version() -> str:
    """Of the program here."""
    return _native.__version__


def alone(job: Job) -> Row:
    """:func:`execute` on one thread, as a task among others on this machine."""
    os.environ.setdefault("RAYON_NUM_THREADS", "1")
    return execute(job)


def execute(job: Job) -> Row:
    """Runs a job: its row.

    :raises FileNotFoundError: where the files that the job was made from are not to be seen
    """
    if os.path.isabs(job.path) and not os.path.exists(job.path) and job.hash != NOTHING:
        raise FileNotFoundError(
            f"{job.path} is not there on {socket.gethostname()}: workers need the folders of the campaigns"
        )
    started = time.perf_counter()
    out = _ran(job)
    if job.command == "track" and out["status"] == "error":
        left_out = {campaign: why for campaign in job.campaigns if (why := _refused(campaign, job.robot))}
        if left_out and len(left_out) < len(job.campaigns):
            out = _without(left_out, job, _ran(job.without(left_out)))
    return out | {"version": version(), "seconds": time.perf_counter() - started}


def _ran(job: Job) -> Row:
    with _arguments(job) as (arguments, temporary):
        try:
            found, _, failed = _native.command([*arguments, *job.settings, "--format=json"])
            return _found(job, json.loads(found), found, failed)
        except Error as error:
            places = [{k: _told(v, temporary, job) for k, v in each.items()} for each in error.diagnostics]
            words = _words(error, places)
            return unsuccessful(job, "error", _told(words, temporary, job), places) | {"exit_status": 2}


def _words(error: Error, places: list[dict[str, Any]]) -> str:
    """What is wrong, in one line."""
    return "; ".join(each["message"] for each in places if each.get("severity") == "error") or str(error)


def _refused(campaign: str, robot: str | None) -> Error | None:
    """Why a campaign of a robot cannot be read or calibrated, if that is so."""
    try:
        _native.command(["identify", campaign, *([f"--robot={robot}"] if robot else []), "--format=json"])
    except Error as error:
        return error
    return None


def _without(left_out: dict[str, Error], job: Job, row: Row) -> Row:
    """The row of a robot's other campaigns, with what is wrong with those that were left out."""
    every, words = [], []
    for campaign, error in left_out.items():
        name = os.path.relpath(campaign, job.path)
        words.append(f"{name} left out: {_words(error, error.diagnostics)}")
        of_it = (each for each in error.diagnostics if each.get("severity") == "error")
        every += [each | {"message": f"{name}: {each['message']}"} for each in of_it]
    status = "incomplete" if row["status"] == "done" else str(row["status"])
    whole = json.loads(row["json"])
    whole["diagnostics"] = [*every, *whole.get("diagnostics", [])]
    return row | {
        **_head(job, status),
        "error": "; ".join([*words, *filter(None, [row.get("error")])]),
        "diagnostics": [*_diagnostics(every), *row["diagnostics"]],
        "json": json.dumps(whole, ensure_ascii=False),
    }


#: Hash of no files.
NOTHING = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"


def unsuccessful(job: Job, status: str, error: str, diagnostics: list[dict[str, Any]]) -> Row:
    """The row of a job without result."""
    text = json.dumps({"diagnostics": diagnostics}, ensure_ascii=False)
    return _head(job, status) | {"error": error, "diagnostics": _diagnostics(diagnostics), "json": text}


def _head(job: Job, status: str) -> Row:
    path, command, settings = job.key
    return {"path": path, "command": command, "settings": settings, "hash": job.hash, "status": status}


@contextlib.contextmanager
def _arguments(job: Job) -> Iterator[tuple[list[str], str | None]]:
    if job.command == "track":
        yield ["track", job.robot or "", *job.campaigns], None
    elif job.command == "blind":
        # A set of this campaign alone.
        with tempfile.TemporaryDirectory(prefix="elastogeo-") as folder:
            (Path(folder) / "truth").mkdir()
            _put(Path(job.path), Path(folder) / Path(job.path).name)
            _put(truth(job.path), Path(folder) / "truth" / truth(job.path).name)
            yield ["blind", "score", folder], folder
    else:
        yield [job.command, job.path], None


def _put(there: Path, here: Path) -> None:
    """A link, or a copy where links are not allowed."""
    try:
        here.symlink_to(there, target_is_directory=there.is_dir())
    except OSError:
        if there.is_dir():
            shutil.copytree(there, here)
        elif there.is_file():
            shutil.copy(there, here)


def _told(value: Any, temporary: str | None, job: Job) -> Any:
    """A text without the name of a temporary folder."""
    return value.replace(temporary, str(Path(job.path).parent)) if isinstance(value, str) and temporary else value


def _found(job: Job, found: dict[str, Any], text: str, failed: bool) -> Row:
    row = _head(job, "unusable" if failed else "done") | {"exit_status": int(failed), "json": text}
    row["diagnostics"] = _diagnostics(found.get("diagnostics", []))
    if failed and row["diagnostics"]:
        row["error"] = row["diagnostics"][0]["message"]
    if job.command == "identify":
        stages, unit = judged(found.get("residuals") or {})
        row |= {stage: _number(rms) for stage, rms in stages.items()}
        row |= {"unit": unit if found.get("residuals") else found.get("unit"), "verdict": "not usable" if failed else "usable"}
        row["parameters"] = [_parameter(each) for each in found.get("parameters", [])]
    elif job.command == "diagnose":
        gap, causes = found.get("gap") or {}, found.get("causes", [])
        row |= {"unit": gap.get("unit"), "before": _number(gap.get("rms"))}
        row["registration"] = _number(gap.get("registration"))
        row |= {"after": _number((found.get("after_all") or gap).get("rms")), "verdict": found.get("verdict")}
        row["causes"] = [_cause(each) for each in causes]
        of = [(f"{cause['effect']}@{cause['site']}:", each) for cause in causes for each in cause.get("parameters", [])]
        row["parameters"] = [_parameter(each, cause) for cause, each in of]
    elif job.command == "blind":
        scored = found["campaigns"][0] if found.get("campaigns") else {}
        row["verdict"] = None if not scored else "right" if scored["right"] else "wrong"
        row["causes"] = [_cause(each) for each in scored.get("said", {}).get("named", [])]
    else:
        row["verdict"] = "changed" if any(each.get("alarm") for each in found.get("checks", [])) else "unchanged"
    return row


def _parameter(each: dict[str, Any], of: str = "") -> Row:
    numbers = {name: _number(each.get(name)) for name in ("nominal", "value", "ci95")}
    marks = {name: each.get(name) for name in ("unit", "identifiable", "at_bound")}
    word = each["value"] if isinstance(each.get("value"), str) else None
    return {"name": of + each["name"], "word": word} | numbers | marks


def _cause(each: dict[str, Any]) -> Row:
    numbers = {name: _number(each.get(name)) for name in ("probability", "shrinkage")}
    return {"effect": each.get("effect"), "site": each.get("site")} | numbers


def _number(value: object) -> float | None:
    """A number; none of what is a word, or infinite."""
    return float(value) if isinstance(value, (int, float)) else None


def _diagnostics(given: list[dict[str, Any]]) -> list[Row]:
    words, place = ("code", "severity", "message", "remedy"), ("file", "line", "column")
    return [{k: each.get(k) for k in words} | {k: (each.get("at") or each).get(k) for k in place} for each in given]

"""Commands of the package as functions: arguments from keywords, results from JSON."""

from __future__ import annotations

import difflib
import json
import logging
import os
import re
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._native import Error
from .effects import Effect, instances
from .observations import Observation, native

Progress = Callable[[str], object]

#: Commands at INFO and DEBUG, what they warn of at WARNING; silent until a program sets logging up.
LOGGER = logging.getLogger("elastogeo")
LOGGER.addHandler(logging.NullHandler())


def named(given: object) -> str:
    """The name or file of a robot or campaign."""
    return os.fspath(getattr(given, "source", given))  # type: ignore[call-overload, no-any-return]


def numbers(values: npt.ArrayLike) -> str:
    """Numbers with all their digits, separated by commas."""
    return ",".join(repr(float(value)) for value in np.asarray(values, dtype=np.float64).ravel())


def flags(**options: object) -> list[str]:
    """Options of the command line: `loss_scale=2` is `--loss-scale=2`; `None` and `False` are left out."""
    out: list[str] = []
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        value = value.item() if isinstance(value, np.generic) else value
        if value is None or value is False:
            continue
        if value is True:
            out.append(flag)
        elif isinstance(value, (str, os.PathLike)):
            out.append(f"{flag}={os.fspath(value)}")
        elif isinstance(value, Mapping):
            out.extend(f"{flag}={key}={each}" for key, each in value.items())
        elif isinstance(value, Iterable):
            out.append(f"{flag}=" + ",".join(str(each) for each in value))
        else:
            out.append(f"{flag}={value}")
    return out


def run(
    arguments: Sequence[str],
    *,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    observations: Sequence[Observation] = (),
) -> tuple[dict[str, Any], str, bool]:
    """Runs a command: its JSON, its text, and whether the result is not to be used."""
    LOGGER.debug("%s begins: %s", arguments[0], arguments[1:])
    if progress is None and LOGGER.isEnabledFor(logging.DEBUG):
        progress = LOGGER.debug
    started = time.perf_counter()
    try:
        json_text, text, failed = _native.command(list(arguments), progress, instances(effects), native(observations))
    except BaseException as error:
        raised = in_keywords(error, arguments[0]) if isinstance(error, Error) else error
        LOGGER.info("%s ends after %.3f s: %s", arguments[0], time.perf_counter() - started, str(raised) or type(raised).__name__)
        if raised is error:
            raise
        raise raised from None
    found: dict[str, Any] = json.loads(json_text)
    for each in found.get("diagnostics", []):
        level = logging.WARNING if each.get("severity") in ("warning", "error") else logging.INFO
        LOGGER.log(level, "%s: %s (%s)", arguments[0], each["message"], each["remedy"])
    usable = "its result is not to be used" if failed else "done"
    LOGGER.info("%s ends after %.3f s: %s", arguments[0], time.perf_counter() - started, usable)
    return found, text, failed


#: How the command line ends its words on options that it does not take.
HELP = "For more information, try '--help'."
#: Keywords that are no options of the command line.
NO_OPTIONS = ("effects", "observations", "progress")
#: Keywords whose options have another name.
RENAMED = {"from": "start", "joints": "q", "as": "format"}


def keyword(option: str) -> str:
    """The keyword of an option.

    >>> keyword("--loss-scale")
    'loss_scale='
    """
    name = option.lstrip("-").replace("-", "_")
    return RENAMED.get(name, name) + "="


def in_keywords(error: Error, command: str) -> Error:
    """What the command line refuses in its options, in the words of a call; any other error as it is."""
    first = error.diagnostics[0] if error.diagnostics else {}
    message, remedy = str(first.get("message")), str(first.get("remedy"))
    if not remedy.endswith(HELP):
        return error
    unknown = re.match(r"unexpected argument '--([\w-]+)", message)
    close = difflib.get_close_matches(unknown[1], NO_OPTIONS, 1, 0.8) if unknown else []

    def said(text: str) -> str:
        return re.sub(r"'?(--[a-z][\w-]*)(?:[= ]<[^>]*>)?'?", lambda found: f"`{keyword(found[1])}`", text)

    name = unknown[1].replace("-", "_") if unknown else ""
    message = f"`{command}` has no argument `{name}=`" if unknown else said(message)
    parts = [part.strip("[]") for part in remedy.split("; ") if not part.startswith(("Usage:", "tip: to pass", HELP))]
    remedy = re.sub(r"tip: (?:a|some) similar \w+ exists?: (.*)", r"did you mean \1?", said("; ".join(parts)))
    if close:
        remedy = f"did you mean `{keyword(close[0])}`?"
    elif unknown and not remedy:
        remedy = f"`elastogeo {command} --help` lists its options, which are keywords with `_` for `-`"
    raised = Error(f"error: {message}" + (f" ({remedy})" if remedy else ""))
    raised.diagnostics = [first | {"message": message, "remedy": remedy or None}, *error.diagnostics[1:]]
    return raised

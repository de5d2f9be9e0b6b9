"""Commands of the package as functions: arguments from keywords, results from JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np
import numpy.typing as npt

from . import _native

if TYPE_CHECKING:
    from .campaign import Campaign
    from .effects import Effect
    from .robot import Robot

Progress = Callable[[str], object]
RobotLike = Union["Robot", str, "os.PathLike[str]"]
CampaignLike = Union["Campaign", str, "os.PathLike[str]"]


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
    arguments: Sequence[str], *, progress: Progress | None = None, effects: Sequence[Effect] = ()
) -> tuple[dict[str, Any], str, bool]:
    """Runs a command: its JSON, its text, and whether the result is not to be used."""
    found, text, failed = _native.command(list(arguments), progress, list(effects))
    return json.loads(found), text, failed

"""What is to be run: campaigns of folders, patterns and lists, each with a hash of its files."""

from __future__ import annotations

import functools
import glob
import hashlib
import importlib
import os
import shlex
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from .. import Campaign, Error, Robot, _native

COMMANDS = ("identify", "diagnose", "track", "blind")
#: Options that name a file to write: all campaigns would write the same one.
WRITING = ("--save", "--save-rules", "--table", "--apply", "--output")


class BadInput(Exception):
    """What was asked for cannot be begun."""


@dataclass(frozen=True)
class Job:
    """One run of a command: on a campaign, or of `track` on the campaigns of a robot."""

    command: str
    #: The campaign's folder or file, of `track` the folder of the campaigns; absolute but for bundled names.
    path: str
    settings: tuple[str, ...]
    #: Of the contents of all files that the result depends on.
    hash: str
    #: Of `track`: the campaigns in the order of time.
    campaigns: tuple[str, ...] = ()
    #: Of `track`: the description.
    robot: str | None = None

    @property
    def key(self) -> tuple[str, str, str]:
        """What a result replaces an earlier one of."""
        return (self.path, self.command, shlex.join(self.settings))

    def without(self, campaigns: Container[str]) -> Job:
        """The job without some of its campaigns, and their days of ``--dates``."""
        left = [campaign not in campaigns for campaign in self.campaigns]
        settings: list[str] = []
        for option in self.settings:
            name, equals, value = option.rpartition("=")
            if "--dates" in (name, settings[-1] if settings else "") and value.count(",") + 1 == len(left):
                option = name + equals + ",".join(each for each, stays in zip(value.split(","), left) if stays)
            settings.append(option)
        kept = tuple(each for each, stays in zip(self.campaigns, left) if stays)
        return replace(self, campaigns=kept, settings=tuple(settings))


def jobs(command: str, given: Sequence[str], options: Sequence[str]) -> list[Job]:
    """The jobs of a command in the order of their paths.

    :raises BadInput: where no campaign is found, or the command does not take the options
    """
    for known in (_content, _named, _is_bundled):
        known.cache_clear()  # files change between runs
    settings, named = _settings(command, options)
    found = campaigns(given)
    if command == "track":
        of_robots: dict[str, list[str]] = {}
        for path in found:
            of_robots.setdefault(str(Path(path).parent), []).append(path)
        return [_track(folder, of_robots[folder], settings, named) for folder in sorted(of_robots)]
    extra: Callable[[str], list[Path]] = _sealed if command == "blind" else lambda _: []
    return [Job(command, path, settings, digest(path, [path], [*extra(path), *named])) for path in found]


def campaigns(given: Iterable[str]) -> list[str]:
    """The campaigns of folders (theirs, or all below), files, patterns, lists of paths, bundled names; each once."""
    found: set[str] = set()
    for each in given:
        path = Path(each)
        if path.is_file() and path.suffix not in (".yaml", ".yml"):
            lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
            of_list = [line.strip() for line in lines if line.strip() and not line.lstrip().startswith("#")]
            # A line that names nothing is a campaign that fails; it does not stop the others.
            found.update(one for line in of_list for one in _below(line) or [os.path.abspath(line)])
            continue
        those = [one for match in sorted(glob.glob(each, recursive=True)) for one in _below(match)] or _below(each)
        if not those:
            raise BadInput(
                f"no campaign at `{each}`: give folders with a `campaign.yaml`, or above such ones, or a list of paths"
            )
        found.update(those)
    if not found:
        raise BadInput("no campaign found: the list is empty")
    return sorted(found)


def _below(given: str) -> list[str]:
    path = Path(given)
    if path.is_file():
        return [os.path.abspath(path)] if path.suffix in (".yaml", ".yml") else []
    if (path / "campaign.yaml").is_file():
        return [os.path.abspath(path)]
    if path.is_dir():
        return [os.path.abspath(file.parent) for file in path.rglob("campaign.yaml")]
    return [given] if not path.exists() and _is_bundled(given) else []


@functools.cache
def _is_bundled(name: str) -> bool:
    try:
        return bool(Campaign(name).poses)
    except Error:
        return False


def _settings(command: str, options: Sequence[str]) -> tuple[tuple[str, ...], list[Path]]:
    """Options with absolute paths, and the files that they name."""
    if command not in _native.command_names():
        raise BadInput(f"this elastogeo {_native.__version__} has no command `{command}`")
    out: list[str] = []
    named: list[Path] = []
    for option in options:
        name, equals, value = option.partition("=") if option.startswith("-") else ("", "", option)
        if name in WRITING:
            raise BadInput(f"`{name}` names one file for all campaigns; the dataset holds every result")
        if os.path.isfile(value):
            value = os.path.abspath(value)
            named.append(Path(value))
        elif "--robot" in (name, out[-1] if out else "") and value:
            try:
                Robot(value)
            except Error as error:
                raise BadInput(_reason(error)) from None
        out.append(f"{name}{equals}{value}")
    nothing = os.path.abspath("no-such-campaign")
    words = {"track": ["track", nothing, nothing], "blind": ["blind", "score", nothing]}.get(
        command, [command, nothing]
    )
    # What is refused without any option is the campaign, which does not exist.
    refused = _refusal([*words, *out])
    if refused is not None and refused.diagnostics != getattr(_refusal(words), "diagnostics", None):
        raise BadInput(_reason(refused))
    return tuple(out), named


def _refusal(words: list[str]) -> Error | None:
    """Why a command refuses its arguments."""
    try:
        _native.command(words)
    except Error as error:
        return error
    return None


def _reason(error: Error) -> str:
    """What is wrong, and what to do about it, in one line."""
    told = [each["message"] + (f" ({each['remedy']})" if each.get("remedy") else "") for each in error.diagnostics]
    return "; ".join(told) or str(error)


def _track(folder: str, found: list[str], settings: tuple[str, ...], named: list[Path]) -> Job:
    robot = None
    # Of the first campaign that can be read.
    for file in map(_file_of, found):
        for text in _strings(file, key="robot"):
            beside = file.parent / text
            robot = robot or (os.path.abspath(beside) if beside.is_file() else text)
    more = [Path(robot)] if robot is not None and os.path.isfile(robot) else []
    return Job("track", folder, settings, digest(folder, found, [*more, *named]), tuple(found), robot)


def _sealed(path: str) -> list[Path]:
    """What else `blind` reads of a sealed campaign: fresh readings, and the truth."""
    place = Path(path)
    return [place / "fresh.yaml", truth(path)]


def truth(path: str) -> Path:
    """The truth of a sealed campaign."""
    return Path(path).parent / "truth" / f"{Path(path).name}.json"


def digest(path: str, found: Iterable[str], more: Iterable[Path]) -> str:
    """Hash of the contents of the files of some campaigns, and where they lie from `path`."""
    files: set[Path] = set()
    for each in [*map(_file_of, found), *more]:
        _collect(each, files)
    whole = hashlib.sha256()
    for name, content in sorted((os.path.relpath(file, path), _content(file)) for file in files):
        whole.update(f"{name}\0{content}\n".encode())
    return whole.hexdigest()


def _file_of(campaign: str) -> Path:
    path = Path(campaign)
    return path / "campaign.yaml" if path.is_dir() else path


def _collect(file: Path, files: set[Path]) -> None:
    """A file and those that it names, and so on."""
    file = Path(os.path.abspath(file))
    if file in files or not file.is_file():
        return
    files.add(file)
    for each in _named(file):
        _collect(each, files)


@functools.cache
def _named(file: Path) -> tuple[Path, ...]:
    """The files that a description or a campaign names."""
    short = (text for text in _strings(file) if 0 < len(text) < 1000 and "\0" not in text)
    return tuple(file.parent / text for text in short if (file.parent / text).is_file())


def _strings(file: Path, key: str | None = None) -> list[str]:
    if file.suffix not in (".yaml", ".yml") or not file.is_file():
        return []
    yaml = importlib.import_module("yaml")  # without stubs
    try:
        read = yaml.load(file.read_text(encoding="utf-8"), getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (yaml.YAMLError, UnicodeDecodeError, ValueError, RecursionError):
        return []
    if key is not None:
        read = read.get(key) if isinstance(read, dict) else None
    return list(_leaves(read))


def _leaves(read: Any) -> Iterator[str]:
    if isinstance(read, str):
        yield read
    for each in read.values() if isinstance(read, dict) else read if isinstance(read, list) else ():
        yield from _leaves(each)


@functools.cache
def _content(file: Path) -> str:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        return f"unreadable: {error.strerror}"

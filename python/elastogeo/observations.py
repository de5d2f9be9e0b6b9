"""Kinds of readings of a program's own: what an instrument reads of a measured point.

>>> import math
>>> class Bearing(Observation):
...     '''A theodolite at an anchor: azimuth and elevation of a marker.'''
...     name = "bearing"
...     columns = {"azimuth": "rad", "elevation": "rad"}
...     target = "anchor"
...     def value(self, point):
...         x, y, z = (at - station for at, station in zip(point.position, point.target))
...         return [math.atan2(y, x), math.atan2(z, math.hypot(x, y))]
>>> bearings = [Bearing()]  # ``Campaign(.., observations=bearings)``
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import Literal

from . import _native
from ._given import instances_of
from ._native import Point

__all__ = ["MOST_VALUES", "Observation", "Point", "kinds"]

#: Greatest number of values of a reading.
MOST_VALUES = 6


class Observation:
    """A kind of readings. A subclass gives the attributes and :meth:`value`; the files of a :class:`Campaign` to which an instance
    is given (``observations=[..]``) may name it."""

    #: Name in campaign files, ``observes: <name>``: small letters, digits and hyphens.
    name: str = ""
    #: One sentence about it.
    about: str = ""
    #: Columns of the measured values and their SI units, lengths first: at most six.
    columns: Mapping[str, Literal["m", "rad"]] = {}
    #: ``"anchor"`` where a reading refers to a fixed point: its column ``anchor`` then names one of the campaign's.
    target: Literal["anchor"] | None = None
    #: Whether the orientation of the tool shows, beyond moving the marker.
    sees_orientation: bool = False
    _kind: _native.Kind | None = None

    def value(self, point: Point) -> Iterable[float]:
        """What an ideal instrument reads of a point, in the order of the columns, SI; angles count to a whole turn. It must be
        smooth, and depend on nothing but its argument; its derivatives are central differences."""
        raise NotImplementedError

    def _declared(self) -> tuple[str, str, list[tuple[str, str]], str | None, bool]:
        if not re.fullmatch(r"[a-z][a-z0-9-]*", self.name):
            raise ValueError(f"a kind of readings has a `name` of small letters, digits and hyphens; here {self.name!r}")
        columns: list[tuple[str, str]] = [(name, unit) for name, unit in self.columns.items()]
        units = [unit for _, unit in columns]
        if not 0 < len(columns) <= MOST_VALUES or units != sorted(units) or not set(units) <= {"m", "rad"}:
            raise ValueError(f"`columns` of {self.name!r}: one to {MOST_VALUES} of the units 'm' and 'rad', lengths first")
        for column, _ in columns:
            if not re.fullmatch(r"[A-Za-z_][\w.]*", column):
                raise ValueError(f"`columns` of {self.name!r}: {column!r} is no name of a column")
        if self.target not in (None, "anchor"):
            raise ValueError(f"`target` of {self.name!r}: 'anchor' or None; here {self.target!r}")
        return self.name, self.about or self.name, columns, self.target, self.sees_orientation


def kinds(observations: object) -> list[Observation]:
    """Kinds of readings as a list, if that is what they are."""
    return instances_of(Observation, "observations", observations)


def native(observations: Iterable[Observation]) -> list[_native.Kind]:
    """Kinds of readings as the native part has them: of each object one, which lives as long as the program."""
    made = []
    for each in observations:
        if each._kind is None:
            each._kind = _native.Kind(each)
        made.append(each._kind)
    return made


def _said(value: Iterable[float], count: int) -> list[float]:
    """A value as the native part reads it."""
    said = [float(each) for each in value]
    if len(said) != count or not all(map(math.isfinite, said)):
        raise ValueError(f"a value is {count} finite number{'s' if count > 1 else ''}, one for each column; here {said}")
    return said

"""What a call is given beyond numbers and files."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

Kind = TypeVar("Kind")


def instances_of(kind: type[Kind], keyword: str, given: object) -> list[Kind]:
    """Instances of a class as a list, if that is what they are.

    :raises TypeError: what else it is, as a class where an instance is expected
    """
    name = f"`elastogeo.{kind.__name__}`"

    def shown(each: object) -> str:
        if isinstance(each, type):
            return f"the class {each.__name__}: give an instance, `{each.__name__}()`"
        return f"{each!r}, a single one: put it into a list" if isinstance(each, kind) else repr(each)

    if isinstance(given, (str, bytes)) or not isinstance(given, Iterable):
        raise TypeError(f"`{keyword}` is a list of instances of {name}; here {shown(given)}")
    every = list(given)
    for each in every:
        if not isinstance(each, kind):
            raise TypeError(f"`{keyword}` holds instances of {name}; here {shown(each)}")
    return every

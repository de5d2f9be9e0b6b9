"""Effects of a program's own: they compete with those of the catalogue.

>>> class HosePull(Effect):
...     '''A hose package turns joint 5 as joints 4 and 6 wind it up.'''
...     name = "hose-pull"
...     sits_at = "joint"
...     sites = ["joint:5"]
...     parameters = {"pull": ("1/rad", 1e-4)}
...     signature = "an angle of one joint that grows with the square of how far the hose is wound up"
...     remedy = "lengthen the hose package"
...     def changes(self, site, reading):
...         wound = reading.q[3] + reading.q[5]
...         return {"pull": joint("q5", wound**2)}
>>> HosePull()._declared()
[('pull', '1/rad', 0.0001, False)]
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence

from ._given import instances_of
from ._native import Reading, Site

__all__ = ["Change", "Changes", "Effect", "Reading", "Site", "deflection", "joint", "parameter", "point"]

#: What changes in a reading: its kind, the variable or parameter, by how much for one unit of the effect's parameter.
Change = tuple[str, str, list[float]]
Changes = Mapping[str, "Change | Sequence[Change]"]


class Effect:
    """An effect that a description leaves out. A subclass gives the attributes and :meth:`changes`."""

    #: Name in the catalogue: letters and hyphens.
    name: str = ""
    #: ``frame``, ``joint``, ``link``, ``actuator``, ``base``, ``tool`` or ``instrument``.
    sits_at: str = "joint"
    #: The only sites where it can be, as ``joint:5``; ``None``: all of its kind.
    sites: Sequence[str] | None = None
    #: By symbol: SI unit, and common size (one sigma); a third entry ``True`` says that it cannot be negative.
    parameters: Mapping[str, tuple[str, float] | tuple[str, float, bool]] = {}
    #: What it looks like in the residuals.
    signature: str = ""
    #: What to do on the machine.
    remedy: str = ""

    def changes(self, site: Site, reading: Reading) -> Changes:
        """What one unit of each parameter changes in a reading, by the parameter's symbol: :func:`joint`, :func:`deflection`,
        :func:`point` or :func:`parameter`, or a list of them. It must depend on nothing but its arguments."""
        raise NotImplementedError

    def _declared(self) -> list[tuple[str, str, float, bool]]:
        if not re.fullmatch(r"[a-z][a-z0-9-]*", self.name) or not self.parameters:
            raise ValueError(f"an effect has a `name` of small letters, digits and hyphens, and `parameters`; here {self.name!r}")
        declared = [(name, own[0], float(own[1]), len(own) > 2 and bool(own[2])) for name, own in self.parameters.items()]
        for name, _, scale, _ in declared:
            if not re.fullmatch(r"[A-Za-z_]\w*", name) or not 0 < scale < math.inf:
                raise ValueError(f"parameter {name!r} of {self.name!r}: a word, and a common size above 0")
        return declared


def instances(effects: object) -> list[Effect]:
    """Effects as a list, if that is what they are."""
    return instances_of(Effect, "effects", effects)


def joint(variable: str, by: float) -> Change:
    """A joint stands elsewhere than commanded, rad or m."""
    return ("joint", variable, [float(by)])


def deflection(variable: str, by: float) -> Change:
    """A joint deflects under load, rad or m: of a difference of two readings only what the applied wrench adds counts."""
    return ("deflection", variable, [float(by)])


def parameter(name: str, by: float) -> Change:
    """A parameter of the robot has another value in this reading, SI."""
    return ("parameter", name, [float(by)])


def point(displacement: Iterable[float], rotation: Iterable[float] = (0.0, 0.0, 0.0)) -> Change:
    """The measured point is displaced (m) and the tool turned (rad), axes of the measurement frame."""
    return ("point", "", [float(value) for value in (*displacement, *rotation)])


def _said(changes: Changes) -> list[tuple[str, str, str, list[float]]]:
    """Changes as the native part reads them."""
    out = []
    try:
        for symbol, given in changes.items():
            for kind, which, by in [given] if isinstance(given, tuple) else given:
                out.append((symbol, kind, which, by))
    except (AttributeError, TypeError, ValueError):
        raise TypeError(
            f"`changes` returns by the symbol of a parameter one of `joint(..)`, `deflection(..)`, `point(..)` and "
            f"`parameter(..)`, or a list of them; here {changes!r}"
        ) from None
    return out

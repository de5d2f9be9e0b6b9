"""The native part. Arrays are of 64-bit floats, SI."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

__version__: str

class Error(ValueError):
    """Why an input cannot be read or a result not be computed; `diagnostics` lists every fault found."""

    diagnostics: list[dict[str, Any]]

def command(
    arguments: Sequence[str],
    progress: Callable[[str], object] | None = None,
    effects: Sequence[object] = (),
    kinds: Sequence[Kind] = (),
) -> tuple[str, str, bool]: ...
def main(arguments: Sequence[str]) -> int: ...
def command_names() -> list[str]: ...
def bundled_robots() -> list[str]: ...

class Robot:
    name: str
    variables: list[tuple[str, bool, tuple[float, float] | None]]
    frames: list[str]
    markers: list[str]
    parameters: list[tuple[str, str, float, float, bool]]
    units: list[float]
    def __new__(cls, name: str, effects: Sequence[object] = ()) -> Robot: ...
    def forward(
        self, q: npt.ArrayLike, at: str | None = None, weight: bool = False, wrench: npt.ArrayLike | None = None
    ) -> Array: ...
    def jacobian(self, q: npt.ArrayLike, at: str | None = None) -> Array: ...
    def compliance(self, q: npt.ArrayLike, at: str | None = None) -> Array: ...
    def solve(
        self, positions: npt.ArrayLike, rotations: npt.ArrayLike | None, starts: npt.ArrayLike, search: dict[str, int | bool]
    ) -> Array: ...

class Kind:
    def __new__(cls, kind: object) -> Kind: ...

class Campaign:
    name: str
    robot: str | None
    observes: str
    readings: int
    poses: list[str]
    warnings: list[str]
    def __new__(
        cls, file: str, robot: str | None = None, effects: Sequence[object] = (), kinds: Sequence[Kind] = ()
    ) -> Campaign: ...
    def csv(self) -> str: ...

class Problem:
    start: list[float]
    bounds: list[tuple[float, float]]
    scale: list[float]
    def __new__(
        cls, campaign: Campaign, parameters: Sequence[str], values: dict[str, float], check: float, seed: int
    ) -> Problem: ...
    def residual(self, x: npt.ArrayLike) -> Array: ...
    def jacobian(self, x: npt.ArrayLike) -> Array: ...

class Site:
    """Where an effect sits."""

    name: str
    variable: int | None

class Reading:
    """The state of the robot in one reading, SI: joints `q`, loads on them under own weight and the applied wrench (`load`) and
    under own weight alone (`own_load`), and the surroundings, where they are known."""

    q: list[float]
    load: list[float]
    own_load: list[float]
    side: list[float]
    last_move: list[float]
    time: float | None
    session_time: float | None
    temperature: float | None
    position: list[float]
    up: list[float]
    deflection: list[float]
    is_difference: bool

class Point:
    """What the model predicts of a measured point (a marker or the tool centre point) under load, SI, axes of the measurement
    frame: its `position`, the `orientation` of the tool (rows of its matrix), the direction of `gravity` (zero where none is
    declared), and `target`: of an anchor its place and zero."""

    position: list[float]
    orientation: list[list[float]]
    gravity: list[float]
    target: list[float]

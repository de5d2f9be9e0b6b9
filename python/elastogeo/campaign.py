"""Measurements of a robot: from files, from tables of any library, and to pandas."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import Array, array
from ._run import RobotLike, named

if TYPE_CHECKING:
    from .effects import Effect
    from .results import Identification


class Campaign:
    """One set of measurements: a ``campaign.yaml``, its folder, or a bundled name.

    >>> campaign = Campaign("kr270-simulated")
    >>> len(campaign), campaign.observes
    (270, 'position')
    """

    def __init__(
        self, source: str | os.PathLike[str], *, robot: RobotLike | None = None, effects: Sequence[Effect] = ()
    ) -> None:
        self.source = os.fspath(source)
        self.effects = list(effects)
        self._given_robot = None if robot is None else named(robot)
        self._native = _native.Campaign(self.source, self._given_robot, self.effects)
        self._folder: tempfile.TemporaryDirectory[str] | None = None

    @classmethod
    def from_table(
        cls,
        table: Any,
        *,
        robot: RobotLike,
        observes: str = "position",
        units: Mapping[str, str] | None = None,
        sigma: float | Mapping[str, float] | None = None,
        estimate: Mapping[str, object] | None = None,
        calibrate: Sequence[str] = (),
        name: str = "from a table",
        folder: str | os.PathLike[str] | None = None,
        effects: Sequence[Effect] = (),
        **more: object,
    ) -> Campaign:
        """A campaign of a table with the columns of a campaign's CSV (``pose``, joints, ``x``, ``y``, ``z``, ..).

        :param table: a data frame of pandas or polars, a pyarrow table, anything else with the Arrow interface
            (``__arrow_c_stream__``, read with pyarrow), or a mapping of names to columns
        :param units: of the table and of ``sigma``, as in campaign files; SI where not given
        :param sigma: noise of the instrument, one sigma of a coordinate
        :param estimate: what is unknown, ``{"base": True, "tool": True}``
        :param folder: where the campaign's files are written, to stay; by default they go with the object
        :param more: further keys of the campaign file
        """
        kept = None if folder is not None else tempfile.TemporaryDirectory(prefix="elastogeo-")
        place = Path(folder if folder is not None else kept.name if kept else ".")
        place.mkdir(parents=True, exist_ok=True)
        of = named(robot)
        header: dict[str, object] = {
            "campaign": name,
            "robot": os.path.abspath(of) if os.path.isfile(of) else of,
            "units": dict(units or {"length": "m", "angle": "rad"}),
            "observes": observes,
            "measurements": "measurements.csv",
        }
        if sigma is not None:
            header["instrument"] = {"sigma": dict(sigma) if isinstance(sigma, Mapping) else sigma}
        if estimate is not None:
            header["estimate"] = dict(estimate)
        if calibrate:
            header["calibrate"] = list(calibrate)
        # JSON is YAML.
        (place / "campaign.yaml").write_text(json.dumps(header | more, indent=1) + "\n", encoding="utf-8")
        columns = columns_of(table)
        with (place / "measurements.csv").open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows(zip(*([cell(value) for value in column] for column in columns.values())))
        own = getattr(robot, "effects", ())
        campaign = cls(place / "campaign.yaml", effects=[*own, *effects])
        campaign._folder = kept
        return campaign

    def __repr__(self) -> str:
        return f"Campaign({self.name!r}): {len(self)} readings at {len(self.poses)} configurations, {self.observes}"

    def __len__(self) -> int:
        return self._native.readings

    @property
    def name(self) -> str:
        """Its name."""
        return self._native.name

    @property
    def robot(self) -> str | None:
        """Its robot's name or file."""
        return self._given_robot or self._native.robot

    @property
    def observes(self) -> str:
        """What a reading is: ``position``, ``pose``, ``deflection``, ``distance``, .."""
        return self._native.observes

    @property
    def poses(self) -> list[str]:
        """Names of the configurations."""
        return self._native.poses

    @property
    def warnings(self) -> list[str]:
        """What is doubtful in its files, one line each."""
        return self._native.warnings

    def to_dict(self) -> dict[str, list[Any]]:
        """The readings by column, as :meth:`from_table` takes them: SI (m, rad, N, N.m, s), to a nanometre."""
        header, *rows = csv.reader(io.StringIO(self._native.csv()))
        return {name: values([row[k] for row in rows]) for k, name in enumerate(header)}

    def to_pandas(self) -> Any:
        """The readings as a pandas data frame, SI.

        >>> frame = Campaign("kr270-simulated").to_pandas()
        >>> frame.shape[0], [name for name in frame.columns if name in "xyz"]
        (270, ['x', 'y', 'z'])
        """
        import pandas

        return pandas.DataFrame(self.to_dict())

    def problem(
        self,
        parameters: Sequence[str],
        start: Identification | Mapping[str, float] | None = None,
        *,
        check: float = 0.25,
        seed: int = 1,
    ) -> Problem:
        """The fit of some parameters as functions for a solver, for example of scipy; see :class:`Problem`.

        :param parameters: names, as ``Identification.kept``
        :param start: values of all parameters as results report them (mm, deg, stiffnesses); by default the description's
        :param check: share of the configurations held out where the campaign does not say, as of ``identify``
        """
        given = dict(start) if isinstance(start, Mapping) else {} if start is None else start.values
        return Problem(self, list(parameters), given, check, seed)


class Problem:
    """Residuals of the readings to fit, in standard deviations, as functions of the parameters (SI; of a spring its compliance).

    >>> campaign = Campaign("kr270-simulated")
    >>> problem = campaign.problem(["base.x", "base.y", "base.z"])
    >>> problem.residual(problem.x0).shape, problem.jacobian(problem.x0).shape
    ((486,), (486, 3))

    ``scipy.optimize.least_squares(problem.residual, problem.x0, problem.jacobian, x_scale=problem.x_scale)`` solves it.
    """

    def __init__(self, campaign: Campaign, names: list[str], values: dict[str, float], check: float, seed: int) -> None:
        #: Names of the parameters, in the order of ``x``.
        self.names = names
        self._native = _native.Problem(campaign._native, names, values, check, seed)
        #: Where they start, SI.
        self.x0: Array = np.array(self._native.start, dtype=np.float64)
        #: How far they are commonly off, SI: a scale for solvers.
        self.x_scale: Array = np.array(self._native.scale, dtype=np.float64)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Least and greatest values, SI."""
        bounds = np.array(self._native.bounds, dtype=np.float64).reshape(-1, 2)
        return bounds[:, 0], bounds[:, 1]

    def residual(self, x: npt.ArrayLike) -> Array:
        """Measured less predicted, in standard deviations, shape (rows,)."""
        return array(self._native.residual(np.asarray(x, dtype=np.float64).tobytes()), -1)

    def jacobian(self, x: npt.ArrayLike) -> Array:
        """Derivatives of :meth:`residual`, shape (rows, parameters)."""
        return array(self._native.jacobian(np.asarray(x, dtype=np.float64).tobytes()), -1, len(self.names))


def columns_of(table: Any) -> dict[str, list[Any]]:
    """The columns of a table of any library.

    >>> columns_of({"pose": ["a", "b"], "q1": (0, 1)})
    {'pose': ['a', 'b'], 'q1': [0, 1]}
    """
    if isinstance(table, Mapping):
        return {str(name): list(column) for name, column in table.items()}
    if hasattr(table, "to_pydict"):  # pyarrow
        columns: dict[str, list[Any]] = table.to_pydict()
    elif hasattr(table, "iloc"):  # pandas
        columns = table.to_dict("list")
    elif hasattr(table, "iter_rows"):  # polars
        columns = table.to_dict(as_series=False)
    elif hasattr(table, "__arrow_c_stream__"):
        import pyarrow

        columns = pyarrow.table(table).to_pydict()
    else:
        raise TypeError(f"{type(table).__name__} is no table: give one with the Arrow interface, or a mapping of columns")
    return {str(name): list(column) for name, column in columns.items()}


def cell(value: object) -> str:
    """A cell of a CSV: numbers with all their digits, nothing for what is missing.

    >>> [cell(value) for value in (0.1, 2, True, None, float("nan"), "m1")]
    ['0.1', '2', '1', '', '', 'm1']
    """
    if value is None or value != value:  # of missing values of all libraries none equals itself
        return ""
    if isinstance(value, (bool, np.bool_)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return str(value)


def values(cells: Iterable[str]) -> list[Any]:
    """A column of a CSV: numbers where all cells are, with nan for empty ones, else texts."""
    given = list(cells)
    try:
        return [float(each) if each else math.nan for each in given] if any(given) else list(given)
    except ValueError:
        return list(given)

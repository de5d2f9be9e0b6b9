"""Measurements of a robot: from files, and from and to tables of any library."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import math
import os
import tempfile
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import Array
from ._native import Error
from ._run import Progress, flags, named, run
from .effects import Effect, instances
from .observations import Observation, kinds, native
from .results import Identification, Result
from .robot import RobotLike


class Campaign:
    """One set of measurements: a ``campaign.yaml``, its folder, or a bundled name.

    >>> campaign = Campaign("kr270-simulated")
    >>> len(campaign), campaign.observes
    (270, 'position')
    """

    def __init__(
        self,
        source: str | os.PathLike[str],
        *,
        robot: RobotLike | None = None,
        effects: Sequence[Effect] = (),
        observations: Sequence[Observation] = (),
    ) -> None:
        self.source = os.fspath(source)
        every = [*getattr(robot, "effects", ()), *instances(effects)]
        self.effects = list({effect.name: effect for effect in every}.values())
        #: Kinds of readings of a program's own that its files name; commands on it know them too.
        self.observations = kinds(observations)
        self._given_robot = None if robot is None else named(robot)
        self._native = _native.Campaign(self.source, self._given_robot, self.effects, native(self.observations))
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
        markers: str | Sequence[str] = (),
        name: str = "from a table",
        folder: str | os.PathLike[str] | None = None,
        force: bool = False,
        effects: Sequence[Effect] = (),
        observations: Sequence[Observation] = (),
        **more: object,
    ) -> Campaign:
        """A campaign of a table with the columns of a campaign's CSV (``pose``, joints, ``x``, ``y``, ``z``, ..).

        :param table: a data frame of pandas or polars, a pyarrow table, anything else with the Arrow interface
            (``__arrow_c_stream__``, read with pyarrow), or a mapping of names to columns; a named index of pandas is a column
        :param units: of the table and of ``sigma``, as in campaign files; SI where not given
        :param sigma: noise of the instrument, one sigma of a coordinate
        :param estimate: what is unknown, ``{"base": True, "tool": True}``
        :param markers: those that each row holds, in columns ``<marker>_x``, ``<marker>_y``, ``<marker>_z``; without it a row
            holds one point, of the marker that its column ``marker`` names
        :param folder: where the campaign's files are written, to stay; by default they go with the object
        :param force: replaces files in the folder that something else wrote, or that were edited since
        :param observations: kinds of readings of your own that ``observes`` may name
        :param more: further keys of the campaign file
        :raises Error: faults of the table, with the row (from 0, as of the columns given), or of the other arguments
        """
        if isinstance(markers, str):
            markers = [markers]
        kept = tempfile.TemporaryDirectory(prefix="elastogeo-") if folder is None else None
        place = Path(folder if folder is not None else kept.name if kept else ".")
        place.mkdir(parents=True, exist_ok=True)
        of = named(robot)
        header: dict[str, object] = {
            "campaign": name,
            "robot": os.path.abspath(of) if os.path.isfile(of) else of,
            "units": dict(units or {"length": "m", "angle": "rad"}),
            "observes": observes,
            "measurements": {"file": "measurements.csv", "markers": list(markers)} if markers else "measurements.csv",
        }
        if sigma is not None:
            header["instrument"] = {"sigma": dict(sigma) if isinstance(sigma, Mapping) else sigma}
        if estimate is not None:
            header["estimate"] = dict(estimate)
        if calibrate:
            header["calibrate"] = list(calibrate)
        columns = columns_of(table)
        # JSON is YAML.
        about = json.dumps(header | more, indent=1, default=_plain) + "\n"
        if not force:
            _spare(place)
        write_csv(place / "measurements.csv", columns)
        (place / "campaign.yaml").write_text(_digest(about, place) + about, encoding="utf-8")
        own = getattr(robot, "effects", ())
        try:
            campaign = cls(place / "campaign.yaml", effects=[*own, *instances(effects)], observations=observations)
        except Error as error:
            if kept is None:
                raise
            with kept:
                raise _of_table(error, kept.name) from None
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

    def check(self, *, progress: Progress | None = None, **options: object) -> Result:
        """What its files say, as the command ``check`` has it: readings, joint ranges, noise, what will be estimated."""
        return Result(*run(["check", self.source, *flags(**options)], progress=progress, effects=self.effects, observations=self.observations))

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

    def to_polars(self) -> Any:
        """The readings as a polars data frame, SI; what is missing is null. It needs polars."""
        import polars

        return polars.DataFrame(self.to_dict()).fill_nan(None)

    def to_arrow(self) -> Any:
        """The readings as a pyarrow table, SI; what is missing is null. It needs pyarrow.

        >>> Campaign("kr270-simulated").to_arrow().num_rows
        270
        """
        import pyarrow

        return pyarrow.table({name: pyarrow.array(each, from_pandas=True) for name, each in self.to_dict().items()})

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """The Arrow interface, by which other libraries read the readings; it needs pyarrow."""
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def problem(
        self,
        parameters: str | Sequence[str],
        start: Identification | Mapping[str, float] | None = None,
        *,
        check: float = 0.25,
        seed: int = 1,
    ) -> Problem:
        """The fit of some parameters as functions for a solver, for example of scipy; see :class:`Problem`.

        :param parameters: names, as ``Identification.kept``
        :param start: values of all parameters as results report them (mm, deg, stiffnesses); by default the description's
        :param check: share of the configurations held out where the campaign does not say, as of ``identify``
        :raises ValueError: a name given twice
        :raises Error: a name that the campaign does not have
        """
        asked = [parameters] if isinstance(parameters, str) else list(parameters)
        twice = next((name for name, often in Counter(asked).items() if often > 1), None)
        if twice is not None:
            raise ValueError(f"parameters: `{twice}` is given twice")
        given = dict(start) if isinstance(start, Mapping) else {} if start is None else start.values
        return Problem(self, asked, given, check, seed)


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
        return self._native.residual(x)

    def jacobian(self, x: npt.ArrayLike) -> Array:
        """Derivatives of :meth:`residual`, shape (rows, parameters)."""
        return self._native.jacobian(x)


#: A campaign, or its name, file or folder.
CampaignLike = Union[Campaign, str, "os.PathLike[str]"]


def columns_of(table: Any) -> dict[str, list[Any]]:
    """The columns of a table of any library.

    >>> columns_of({"pose": ["a", "b"], "q1": (0, 1)})
    {'pose': ['a', 'b'], 'q1': [0, 1]}
    """
    columns: Mapping[Any, Iterable[Any]]
    if isinstance(table, Mapping):
        columns = table
    elif hasattr(table, "to_pydict"):  # pyarrow
        columns = table.to_pydict()
    elif hasattr(table, "iloc"):  # pandas
        columns = table.reset_index([name for name in table.index.names if name is not None]).to_dict("list")
    elif hasattr(table, "iter_rows"):  # polars
        columns = table.to_dict(as_series=False)
    elif hasattr(table, "__arrow_c_stream__"):
        import pyarrow

        columns = pyarrow.table(table).to_pydict()
    else:
        raise TypeError(f"{type(table).__name__} is no table: give one with the Arrow interface, or a mapping of columns")
    found = {str(name): list(column) for name, column in columns.items()}
    if len({len(column) for column in found.values()}) > 1:
        lengths = ", ".join(f"{name} {len(column)}" for name, column in found.items())
        raise ValueError(f"columns of a table have one length; here {lengths}")
    return found


def write_csv(file: str | os.PathLike[str], columns: Mapping[str, Sequence[Any]]) -> None:
    """Writes columns as a CSV."""
    with open(file, "w", encoding="utf-8", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*([cell(value) for value in column] for column in columns.values())))


def _digest(about: str, place: Path) -> str:
    """First line of a campaign's file: what shows later that nobody edited what `from_table` wrote."""
    whole = hashlib.sha256(about.encode() + (place / "measurements.csv").read_bytes()).hexdigest()
    return f"# written by from_table of a Python program; SHA-256 of what follows and of measurements.csv: {whole}\n"


def _of_table(error: Error, folder: str) -> Error:
    """An error of files that go with it, in terms of the table that they were written from."""
    told: list[str] = []
    every: list[dict[str, Any]] = []
    for given in error.diagnostics:
        each, message = dict(given), str(given["message"]).replace(folder + os.sep, "")
        of, row = os.path.split(given.get("file") or ""), (given.get("line") or 0) - 2
        if of[0] == folder:
            each |= {"file": None, "line": None, "column": None, "excerpt": None}
            if of[1] == "measurements.csv":
                message = f"row {row} of the table: {message}" if row >= 0 else f"the table: {message}"
                each |= {"row": row} if row >= 0 else {}
        every.append(each | {"message": message})
        told.append(f"{given['severity']}: {message}" + (f" ({given['remedy']})" if given.get("remedy") else ""))
    raised = Error("\n".join(told))
    raised.diagnostics = every
    return raised


def _spare(place: Path) -> None:
    """Refuses a folder with a campaign that `from_table` did not write, or that was edited since."""
    about, readings = place / "campaign.yaml", place / "measurements.csv"
    there = [file.name for file in (about, readings) if file.exists()]
    if not there:
        return
    first, _, rest = about.read_text(encoding="utf-8", errors="replace").partition("\n") if about.exists() else ("", "", "")
    if len(there) < 2 or f"{first}\n" != _digest(rest, place):
        raise FileExistsError(
            f"`{place}` has a {' and a '.join(there)} of its own, or edited since: give another folder, or replace with force=True"
        )


def _plain(value: object) -> object:
    """Numbers and arrays of numpy, and paths, as JSON has them."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{type(value).__name__} {value!r} cannot stand in a campaign file")


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

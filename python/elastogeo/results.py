"""What commands find: the command's JSON, with tables, arrays and plots."""

from __future__ import annotations

import html
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from . import plots
from ._arrays import Array


#: Rows of a table that a notebook shows.
SHOWN = 50
#: Parameters of the robot's place, which a plot of its changes leaves out.
BASE = {f"base.{symbol}" for symbol in ("x", "y", "z", "rx", "ry", "rz")}


class Result:
    """What a command found: :meth:`to_dict` is its JSON, ``print`` shows its text."""

    #: Lines of the text that are the answer.
    _answer = 0

    def __init__(self, found: dict[str, Any], text: str, failed: bool) -> None:
        self._found = found
        self.text = text
        #: Whether the result may be used: exit status 0 of the command.
        self.usable = not failed

    def to_dict(self) -> dict[str, Any]:
        """The command's JSON (``--format json``)."""
        return self._found

    def __getitem__(self, key: str) -> Any:
        return self._found[key]

    @property
    def diagnostics(self) -> list[dict[str, Any]]:
        """Warnings: code, severity, message, remedy and, below ``at``, the place in the file."""
        found: list[dict[str, Any]] = self._found.get("diagnostics", [])
        return found

    def __repr__(self) -> str:
        return self.text

    def _plot(self) -> str:
        return ""

    def _tables(self) -> list[str]:
        return []

    def _repr_html_(self) -> str:
        lines = [line for line in self.text.splitlines() if line.strip()][: self._answer]
        head = "".join(f"<p><b>{html.escape(line)}</b></p>" for line in lines)
        shown = self._plot() + "".join(self._tables())
        text = f"<summary>all</summary><pre>{html.escape(self.text)}</pre>"
        return f"{head}{shown}<details>{text}</details>" if shown else f"<pre>{html.escape(self.text)}</pre>"


class Identification(Result):
    """What ``identify`` and ``register`` find. Lengths in mm, angles in deg, stiffnesses in SI."""

    _answer = 2

    def __init__(self, found: dict[str, Any], text: str, failed: bool, robot: str | None = None) -> None:
        super().__init__(found, text, failed)
        #: File of the calibrated description; ``None`` where it was not written.
        self.file = robot if robot is not None and os.path.isfile(robot) else None

    @property
    def parameters(self) -> Any:
        """A row for each parameter: name, unit, nominal, value, ci95, identifiable, at_bound, ..; a pandas data frame."""
        return data_frame(self._found["parameters"])

    @property
    def kept(self) -> list[str]:
        """Names of the parameters that were identified."""
        kept: list[str] = self._found["kept_parameters"]
        return kept

    @property
    def values(self) -> dict[str, float]:
        """Values by name, mm, deg and SI; infinite where a stiffness is rigid."""
        return {each["name"]: _number(each["value"]) for each in self._found["parameters"]}

    @property
    def rms(self) -> dict[str, float | None]:
        """Root mean square errors before, with base and tool fitted alone, and calibrated, of readings not seen (else of those
        fitted); mm, or :attr:`unit` of readings of angles or torques alone."""
        return judged(self._found["residuals"])[0]

    @property
    def unit(self) -> str:
        """Unit of :attr:`rms`: ``mm``, ``deg`` or ``N.m``."""
        return judged(self._found["residuals"])[1]

    def _plot(self) -> str:
        shown: dict[str, list[tuple[str, float, float | None]]] = {"mm": [], "deg": [], "%": []}
        for each in self._found.get("parameters", []):
            if not each["identifiable"] or each["nominal"] is None or each["name"] in BASE:
                continue
            nominal, change, width = _number(each["nominal"]), _number(each["value"]), each["ci95"] or 0.0
            change -= nominal
            if each["unit"] in shown:
                shown[each["unit"]].append((each["name"], change, width))
            elif nominal:
                shown["%"].append((each["name"], 100 * change / abs(nominal), 100 * width / abs(nominal)))
        return "".join(plots.intervals(f"changes, {unit}", rows) for unit, rows in shown.items())

    def _tables(self) -> list[str]:
        columns = ("name", "unit", "nominal", "value", "ci95", "at_bound")
        if "parameters" not in self._found:  # schemes side by side, or rules
            return []
        return [
            plots.table([{"stage": stage, f"rms, {self.unit}": rms} for stage, rms in self.rms.items()]),
            plots.table([{c: e[c] for c in columns} for e in self._found["parameters"] if e["identifiable"]]),
        ]


class Diagnosis(Result):
    """What ``diagnose`` finds."""

    _answer = 2

    @property
    def verdict(self) -> str:
        """``no-gap``, ``explained``, ``partly-explained`` or ``unexplained``."""
        return str(self._found["verdict"])

    @property
    def causes(self) -> Any:
        """A row for each cause: effect, site, probability, rms before and after, shrinkage; a pandas data frame."""
        return data_frame([{k: v for k, v in each.items() if _is_plain(v)} for each in self._found["causes"]])

    @property
    def sites(self) -> Any:
        """The share of the gap that could come from each site; a pandas data frame."""
        return data_frame(self._found["where"]["sites"])

    def _plot(self) -> str:
        bars = [(each["site"], each["share"]) for each in self._found["where"]["sites"] if each["share"] > 0]
        return plots.bars("share of the gap that could come from each site", bars)

    def _tables(self) -> list[str]:
        return [plots.table([{k: v for k, v in each.items() if _is_plain(v)} for each in self._found["causes"]])]


class Stiffness(Result):
    """What ``stiffness`` finds; SI, base axes, (displacement, rotation) against (force, moment)."""

    @property
    def stiffness(self) -> Array:
        """Shape (6, 6)."""
        return np.array(self._found["stiffness"], dtype=np.float64)

    @property
    def compliance(self) -> Array:
        """Shape (6, 6)."""
        return np.array(self._found["compliance"], dtype=np.float64)

    @property
    def deflection(self) -> Array:
        """Shape (6,): m and rad."""
        return np.array(self._found["deflection"], dtype=np.float64)

    @property
    def shares(self) -> dict[str, float]:
        """Share of the work by each element."""
        shares: dict[str, float] = self._found["shares"]
        return shares

    def _plot(self) -> str:
        return plots.bars("share of each element", list(self.shares.items()))


class Residuals(Result):
    """What ``residuals`` finds: mm (deg and N.m of other readings), measured less predicted."""

    @property
    def readings(self) -> Any:
        """A row for each reading; a pandas data frame."""
        return data_frame(self._found["readings"])

    @property
    def errors(self) -> list[Array]:
        """The error of each reading, coordinate by coordinate."""
        return [np.array(each["error"], dtype=np.float64) for each in self._found["readings"]]

    def _plot(self) -> str:
        sizes = [float(np.linalg.norm(error[:3])) for error in self.errors if error.size]
        return plots.histogram(f"error of the readings, {self._found['unit']}", sizes)


class Sensitivity(Result):
    """What ``sensitivity`` finds, SI: how far the tool moves for one unit of each parameter."""

    @property
    def parameters(self) -> Any:
        """A row for each parameter of the geometry: name, ``position_mean`` and ``position_max`` (m for one m or rad),
        ``rotation_mean`` and ``rotation_max`` (rad for one m or rad); a pandas data frame."""
        return data_frame([{"name": each["name"]} | _moved(each) for each in self._found["parameters"]])

    @property
    def elastic(self) -> Any:
        """A row for each compliance under the campaign's loads: name, its unit and declared value, the same for one unit of
        it, and for its declared value (``position_mean_of_value`` in m, ..); a pandas data frame, empty where nothing is elastic."""
        return data_frame([
            {key: each[key] for key in ("name", "unit", "value")} | _moved(each) | _moved(each, "_of_value")
            for each in self._found.get("elastic") or []
        ])  # fmt: skip

    def _tables(self) -> list[str]:
        names = ("name", "position_mean", "position_max", "rotation_mean", "rotation_max")
        tables = [plots.table([{"name": each["name"]} | _moved(each) for each in self._found["parameters"]])]
        own = [{"name": each["name"]} | _moved(each, "_of_value") for each in self._found.get("elastic") or []]
        return [*tables, plots.table([dict(zip(names, each.values())) for each in own])]


class Identifiability(Result):
    """What ``identifiability`` finds; columns are scaled, so that its numbers have no unit."""

    @property
    def rank(self) -> int:
        """Rank of the matrix of derivatives."""
        return int(self._found["rank"])

    @property
    def kept(self) -> list[str]:
        """Names of the parameters that the campaign tells."""
        kept: list[str] = self._found["kept_parameters"]
        return kept

    @property
    def dropped(self) -> Any:
        """A row for each parameter that it does not tell: name, why, and ``into``, the parameters that take its effect over
        with their factors; a pandas data frame."""
        return data_frame(self._dropped())

    @property
    def singular_values(self) -> Array:
        """Shape (kept,), from the greatest."""
        return np.array(self._found["singular_values"], dtype=np.float64)

    @property
    def condition(self) -> float:
        """Greatest singular value by the least; infinite where nothing is kept."""
        return _number(self._found["condition"])

    @property
    def observability(self) -> dict[str, float | None]:
        """The indices ``O1`` to ``O5``."""
        found: dict[str, float | None] = self._found["observability"]
        return found

    def _dropped(self) -> list[dict[str, Any]]:
        combinations: dict[str, dict[str, float]] = self._found["combinations"]
        return [
            each | {"into": {name: factors[each["name"]] for name, factors in combinations.items() if each["name"] in factors}}
            for each in self._found["dropped"]
        ]

    def _plot(self) -> str:
        return plots.decades("singular values", self.singular_values.tolist())

    def _tables(self) -> list[str]:
        numbers = {"columns": self._found["columns"], "rank": self.rank, "kept": len(self.kept), "condition": self.condition}
        dropped = [
            {"dropped": each["name"], "why": each["why"], "into": ", ".join(f"{to} {by:.3g}" for to, by in each["into"].items())}
            for each in self._dropped()
        ]
        return [plots.table([numbers | self.observability]), plots.table(dropped)]


class Compensator(Result):
    """What ``compensator`` finds: mm, deg, 1e-6 m/N and 1e-6 rad/(N.m)."""

    @property
    def parameters(self) -> Any:
        """A row for each: name (``L``, ``ax``, ``ay`` of the mounting; ``k2_0``, ``kc``, ``s0`` of joint and spring; ``a`` and
        ``phi``), value, ci95, unit; a pandas data frame."""
        return data_frame(self._rows())

    @property
    def compliances(self) -> Any:
        """A row for each angle: q (deg), compliance of the joint and ci95, and what is fitted, 1e-6 rad/(N.m); a pandas data
        frame, empty where the mounting alone was asked for."""
        return data_frame(self._by_angle())

    def _rows(self) -> list[dict[str, Any]]:
        named = {name: each for name, each in self._found.items() if isinstance(each, dict) and {"value", "unit"} <= set(each)}
        rows = {name: {"value": each["value"], "ci95": each.get("ci95"), "unit": each["unit"]} for name, each in named.items()}
        return [{"name": name} | row for name, row in rows.items() if name != "rms"]

    def _by_angle(self) -> list[dict[str, Any]]:
        rows: list[dict[str, Any]] = (self._found.get("compliances") or {}).get("rows", [])
        return rows

    def _tables(self) -> list[str]:
        return [plots.table(self._rows()), plots.table(self._by_angle())]


class Configurations(Result):
    """Configurations of a robot, one after another."""

    def __init__(self, found: dict[str, Any], text: str, failed: bool, key: str, variables: list[str]) -> None:
        super().__init__(found, text, failed)
        self._rows: list[dict[str, Any]] = found.get(key, [])
        self.variables = variables

    @property
    def joints(self) -> Array:
        """Shape (n, joints), rad and m; nan where a point was refused."""
        rows = [[_joints(each).get(name, np.nan) for name in self.variables] for each in self._rows]
        return np.array(rows, dtype=np.float64).reshape(-1, len(self.variables))

    @property
    def table(self) -> Any:
        """A row for each configuration, its joints in columns (rad and m, nan where it was refused); of ``compensate`` the
        column ``status`` says ``ok`` or why a point was refused. A pandas data frame."""
        plain = [{k: v for k, v in each.items() if k != "joints" and _is_plain(v)} | _joints(each) for each in self._rows]
        return data_frame(plain)

    def _tables(self) -> list[str]:
        shown = [
            {key: each[key] for key in ("pose", "name", "status") if key in each} | dict(zip(self.variables, row))
            for each, row in zip(self._rows[:SHOWN], self.joints.tolist())
        ]
        return [plots.table(shown)]


class Compensation(Configurations):
    """Commands corrected by ``compensate``."""


class Plan(Configurations):
    """Configurations chosen by ``plan``."""

    @property
    def error(self) -> float | None:
        """Error after compensation to expect at the test poses, mm, rms."""
        error: float | None = self._found["error"]["planned"]
        return error

    @property
    def bought(self) -> Any:
        """A row for each number of configurations: the error to expect of planned and of random ones, mm; a pandas data
        frame."""
        return data_frame(self._found.get("bought") or [])

    @property
    def parameters(self) -> Any:
        """A row for each parameter: name, unit, and the ci95 to expect, half a 95 % interval; a pandas data frame."""
        return data_frame(self._found.get("parameters") or [])

    def _plot(self) -> str:
        bought = [(f"{each['poses']} poses", each["planned"]) for each in self._found.get("bought") or [] if each.get("planned")]
        return plots.bars(f"error to expect, {self._found.get('unit', 'mm')}", bought)

    def _tables(self) -> list[str]:
        return [*super()._tables(), plots.table((self._found.get("parameters") or [])[:SHOWN])]


class Placement(Configurations):
    """What ``place`` finds: m and rad, base axes."""

    @property
    def motion(self) -> Array:
        """Shape (6,): displacement (m) and rotation vector (rad, about the origin of the base) that bring the path where it is
        best."""
        return np.array(self._found["moved"]["motion"], dtype=np.float64)

    @property
    def deflections(self) -> Any:
        """Rows ``given``, ``posture`` (where the path is, with the best posture) and ``best``: rms and max along the path, m; a
        pandas data frame."""
        return data_frame(self._stages())

    def _stages(self) -> list[dict[str, Any]]:
        return [{"stage": stage} | self._found[stage] for stage in ("given", "posture", "best") if self._found.get(stage)]

    def _plot(self) -> str:
        unit = self._found.get("unit", "m")
        return plots.bars(f"deflection, rms, {unit}", [(each["stage"], each["rms"]) for each in self._stages() if each["rms"]])

    def _tables(self) -> list[str]:
        return [plots.table(self._stages()), *super()._tables()]


class Simulated(Result):
    """What ``simulate`` wrote: its folder, and the truth."""

    def __init__(self, found: dict[str, Any], text: str, failed: bool, folder: str) -> None:
        super().__init__(found, text, failed)
        self.folder = folder

    @property
    def truth(self) -> Any:
        """The parameters with which it was made, SI; a pandas data frame."""
        return data_frame([{"name": name} | each for name, each in self._found["truth"]["parameters"].items()])


class Page(Result):
    """What a command that writes a page finds."""

    def __init__(self, found: dict[str, Any], text: str, failed: bool, html: str) -> None:
        super().__init__(found, text, failed)
        #: The page, self-contained.
        self.html = html

    def _repr_html_(self) -> str:
        return f'<iframe style="width:100%;height:40em;border:0" srcdoc="{html.escape(self.html)}"></iframe>'


class Report(Page):
    """The page that ``report`` wrote."""


class View(Page):
    """The page that ``view`` wrote."""


class Track(Page):
    """What ``track`` finds, and its page with the control charts."""

    @property
    def answer(self) -> str:
        """What has changed, in a sentence."""
        return str(self._found["answer"])

    @property
    def changed(self) -> bool:
        """Whether any check shows a change of the robot."""
        return any(each["alarm"] for each in self._found["checks"])

    @property
    def checks(self) -> Any:
        """A row for each campaign: name, date, number of poses, statistic and its limit, p, alarm, errors held out (mm), what
        happened (``event``), ..; a pandas data frame."""
        return data_frame(self._found["checks"])

    @property
    def parameters(self) -> Any:
        """A row for each parameter and check: name, unit, changed, check, and the difference from the reference with its
        ci95; a pandas data frame."""
        names = [each["name"] for each in self._found["checks"]]
        return data_frame([
            {key: each[key] for key in ("name", "unit", "changed")} | {"check": check} | (value or {})
            for each in self._found["parameters"]
            for check, value in zip(names, each["values"])
        ])  # fmt: skip

    @property
    def next(self) -> Any:
        """A row for each change that the next check is to show: name, unit, change, and the poses that it needs, none where
        they would not do; a pandas data frame."""
        return data_frame(self._found["next"])


def _joints(row: Mapping[str, Any]) -> dict[str, float]:
    """Joints of a configuration by name; none of a point that was refused."""
    return row.get("joints") or {}


def _moved(row: Mapping[str, Any], of: str = "") -> dict[str, float]:
    """How far the tool moves: mean and greatest displacement and rotation."""
    kinds = (("position", row["mu_P" + of]), ("rotation", row["mu_Phi" + of]))
    return {f"{kind}_{each}{of}": by[each] for kind, by in kinds for each in ("mean", "max")}


def _is_plain(value: object) -> bool:
    return value is None or isinstance(value, (str, int, float))


def _number(value: float | None) -> float:
    return float("inf") if value is None else value


def judged(residuals: Mapping[str, Any]) -> tuple[dict[str, float | None], str]:
    """Root mean square errors by stage and their unit, of readings not seen (else of those fitted): of positions, or where no
    lengths were read of angles or torques.

    >>> judged({"before": {"rms": 0.0, "orientation": {"rms": 0.2}}, "after": {"rms": 0.0, "orientation": {"rms": 0.1}}})
    ({'before': 0.2, 'registration': None, 'after': 0.1}, 'deg')
    """
    check = "check_" if residuals.get("check_after") else ""
    stages = {stage: residuals.get(check + stage) or {} for stage in ("before", "registration", "after")}
    of, unit = "", "mm"
    if not any(errors.get("rms") for errors in stages.values()):
        for name, its in (("orientation", "deg"), ("load", "N.m")):
            if not of and name in stages["after"]:
                of, unit = name, its
    found = {stage: (errors.get(of) or {}) if of else errors for stage, errors in stages.items()}
    return {stage: errors.get("rms") for stage, errors in found.items()}, unit


def data_frame(rows: list[dict[str, Any]]) -> Any:
    """Rows as a pandas data frame."""
    import pandas  # here, so that a program without tables starts sooner

    return pandas.DataFrame(rows)

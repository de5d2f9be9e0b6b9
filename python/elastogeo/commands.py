"""The commands as functions. Options that have no argument of their own are those of the command line, with ``_`` for ``-``
(``identify(.., loss_scale=2)`` is ``identify .. --loss-scale 2``), in the description's units."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._arrays import Array, finite, rows
from ._run import Progress, flags, named, numbers, run
from .campaign import CampaignLike, columns_of, write_csv
from .effects import Effect, instances
from .results import Configurations, Diagnosis, Identification, Report, Residuals, Result, Simulated, Stiffness
from .robot import Joints, Robot, RobotLike, placed


def identify(
    campaign: CampaignLike,
    *,
    robot: RobotLike | None = None,
    what: str | Sequence[str] | None = None,
    save: str | os.PathLike[str] | None = None,
    hold: Sequence[str] | None = None,
    loss: str | None = None,
    prior: bool = False,
    check: float | None = None,
    seed: int = 1,
    force: bool = False,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Identification:
    """Calibrates a robot on a campaign and judges it on poses that the fit did not see.

    :param what: ``geometric``, ``elastic`` or both; by default stiffness from deflections and geometry from all other readings
    :param save: file for the calibrated description (``.yaml`` or ``.urdf``)
    :param hold: parameters to hold at their nominal values
    :param loss: ``squares``, ``huber``, ``cauchy`` or ``tukey``
    :param progress: called with a line of text between iterations; an exception that it raises stops the work
    :raises Error: bad input, or a result that is implausible (with ``force`` that is a warning)

    >>> found = identify("kr270-simulated")
    >>> found.usable, len(found.kept)
    (True, 33)
    """
    given = flags(
        robot=_named(robot), what=what, hold=hold, loss=loss, prior=prior, check=check, seed=seed, force=force, **options
    )
    file = None if save is None else os.fspath(save)
    saved = flags(save=file)
    return Identification(
        *run(["identify", named(campaign), *given, *saved], progress=progress, effects=_effects(campaign, robot, effects)),
        robot=file,
    )


def register(
    campaign: CampaignLike,
    *,
    robot: RobotLike | None = None,
    save: str | os.PathLike[str] | None = None,
    seed: int = 1,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Identification:
    """Where the robot stands and what its tool is: base, tool and markers fitted alone."""
    given = flags(robot=_named(robot), save=save, seed=seed, **options)
    found = run(["register", named(campaign), *given], progress=progress, effects=_effects(campaign, robot, effects))
    return Identification(*found, robot=None if save is None else os.fspath(save))


def diagnose(
    campaign: CampaignLike,
    *,
    robot: RobotLike | None = None,
    apply: str | os.PathLike[str] | None = None,
    seed: int = 1,
    force: bool = False,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Diagnosis:
    """Where the sim-to-real gap lies, which effect causes it, how far it shrinks on readings not seen.

    :param apply: file for the description as diagnosed: calibrated, effects switched on
    :param progress: called with a line of text between stages; an exception that it raises stops the work
    :param effects: effects of your own, which compete with those of the catalogue

    >>> found = diagnose("kr270-no-compensator")
    >>> found.verdict, found["causes"][0]["effect"], found["causes"][0]["site"]
    ('explained', 'gravity-compensator', 'joint:2')
    """
    given = flags(robot=_named(robot), apply=apply, seed=seed, force=force, **options)
    arguments = ["diagnose", named(campaign), *given]
    return Diagnosis(*run(arguments, progress=progress, effects=_effects(campaign, robot, effects)))


def residuals(robot: RobotLike, campaign: CampaignLike, **options: object) -> Residuals:
    """Compares a description with measurements, fitting nothing."""
    arguments = ["residuals", named(robot), named(campaign), *flags(**options)]
    return Residuals(*run(arguments, effects=_effects(campaign, robot)))


def identifiability(robot: RobotLike, campaign: CampaignLike, **options: object) -> Result:
    """What a campaign can tell: rank, what is dropped and merged into what, conditioning, observability."""
    arguments = ["identifiability", named(robot), named(campaign), *flags(**options)]
    return Result(*run(arguments, effects=_effects(campaign, robot)))


def stiffness(robot: RobotLike, q: Joints, **options: Any) -> Stiffness:
    """Stiffness at one configuration: :meth:`Robot.stiffness`.

    >>> stiffness("kuka-kr270", [0, -1.0, 1.5, 0, 0.3, 0], wrench=[0, 0, -2500, 0, 0, 0]).compliance.shape
    (6, 6)
    """
    return _robot(robot).stiffness(q, **options)


def plan(
    robot: RobotLike,
    poses: int,
    *,
    wrench: npt.ArrayLike | None = None,
    seed: int = 1,
    progress: Progress | None = None,
    **options: object,
) -> Configurations:
    """Chooses the configurations (and loads) to measure that leave the smallest error after compensation.

    :param poses: how many
    :param wrench: loads that can be applied, base axes, shape (6,) or (k, 6), N and N.m
    :return: ``joints`` of shape (poses, joints), rad and m
    """
    own = _robot(robot)
    arguments = ["plan", own.source, *flags(poses=poses, seed=seed, **options), *_wrenches(own, wrench)]
    found = run(arguments, progress=progress, effects=own.effects)
    return Configurations(*found, key="poses", variables=own.variables)


def compensate(
    robot: RobotLike,
    path: Any,
    *,
    nominal: RobotLike | None = None,
    wrench: npt.ArrayLike | None = None,
    start: Joints | None = None,
    **options: object,
) -> Configurations:
    """Commands under which the real robot passes where it should: geometry, own weight, load and effects corrected.

    :param robot: the robot as calibrated
    :param path: poses of shape (n, 4, 4) or (4, 4), positions of shape (n, 3) or (3,), m, base frame; joints of shape (n, joints)
        or (joints,), rad and m; a table with the columns of the command's path (SI); or the name of a file
    :param nominal: the description that the controller works with
    :param wrench: load of all points of shape (6,), or of each of shape (n, 6); base axes, N and N.m
    :param start: joints from which the first point is sought
    :return: ``joints`` of shape (n, joints): the commands; nan where a point is refused
    """
    own = _robot(robot)
    wrenches, is_one = (None, True) if wrench is None else rows(wrench, 6, "wrench")
    of_all = wrench if is_one else None
    given = flags(nominal=_named(nominal), wrench=own._wrench(of_all), **{"from": own._joints(start)}, **options)
    with tempfile.TemporaryDirectory(prefix="elastogeo-") as folder:
        if isinstance(path, (str, os.PathLike)):
            file = os.fspath(path)
            if not is_one:
                raise ValueError("a wrench for each point of a file stands in its columns fx, .., mz")
        else:
            file = str(Path(folder) / "path.csv")
            columns = _path(own, path) if isinstance(path, (np.ndarray, list, tuple)) else columns_of(path)
            if wrenches is not None and not is_one:
                columns |= _loads(finite(wrenches, "wrench"), columns)
            write_csv(file, columns)
            given += flags(units="length=m,angle=rad,force=N,torque=N.m")
        found = run(["compensate", own.source, file, *given], effects=own.effects)
    return Configurations(*found, key="points", variables=own.variables)


def simulate(
    robot: RobotLike,
    poses: int | npt.ArrayLike,
    into: str | os.PathLike[str],
    *,
    wrench: npt.ArrayLike | None = None,
    seed: int = 1,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Simulated:
    """Makes a campaign from a description with drawn or given errors, in the folder ``into``: ``Campaign(into)`` reads it.

    :param poses: how many configurations to draw, or joints of shape (n, joints), rad and m
    :param wrench: loads read at each marker, base axes, shape (6,) or (k, 6), N and N.m
    :param options: of the command, for example ``effect="gear-ratio@joint:2:ratio=5e-4"``, ``noise=0.05`` (mm)
    """
    own = _robot(robot, effects)
    with tempfile.TemporaryDirectory(prefix="elastogeo-") as folder:
        asked: object = poses
        if not isinstance(poses, (int, np.integer)):
            asked = str(Path(folder) / "poses.csv")
            length, angle, _, _ = own._native.units
            sizes = np.array([angle if is_angle else length for is_angle in own.is_angle])
            joints = finite(rows(poses, len(sizes), "poses")[0], "poses")
            write_csv(str(asked), dict(zip(own.variables, (joints / sizes).T.tolist())))
        given = flags(poses=asked, into=into, seed=seed, **options)
        found = run(["simulate", own.source, *given, *_wrenches(own, wrench)], effects=own.effects)
    return Simulated(*found, folder=os.fspath(into))


def report(
    campaign: CampaignLike,
    output: str | os.PathLike[str] | None = None,
    *,
    robot: RobotLike | None = None,
    seed: int = 1,
    force: bool = False,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Report:
    """A campaign in one self-contained HTML page: ``html`` of the result, and the file ``output`` where one is named."""
    with tempfile.TemporaryDirectory(prefix="elastogeo-") as folder:
        file = os.fspath(output) if output is not None else str(Path(folder) / "report.html")
        given = flags(output=file, robot=_named(robot), seed=seed, force=force, **options)
        own = _effects(campaign, robot, effects)
        found = run(["report", named(campaign), *given], progress=progress, effects=own)
        return Report(*found, html=Path(file).read_text(encoding="utf-8"))


def _robot(robot: RobotLike, effects: Sequence[Effect] = ()) -> Robot:
    if isinstance(robot, Robot) and not effects:
        return robot
    return Robot(named(robot), effects=_effects(robot, None, effects))


def _named(robot: RobotLike | None) -> str | None:
    return None if robot is None else named(robot)


def _effects(of: object, robot: object = None, more: Sequence[Effect] = ()) -> list[Effect]:
    """Effects of a campaign, of its robot and of a call; of one name the last."""
    every = [*getattr(robot, "effects", ()), *getattr(of, "effects", ()), *instances(more)]
    return list({effect.name: effect for effect in every}.values())


def _wrenches(robot: Robot, wrench: npt.ArrayLike | None) -> list[str]:
    if wrench is None:
        return []
    given, _ = rows(wrench, 6, "wrench")
    _, _, force, torque = robot._native.units
    return [f"--wrench={numbers(each / np.array([force] * 3 + [torque] * 3))}" for each in given]


def _path(robot: Robot, path: Any) -> dict[str, list[Any]]:
    points: Array = finite(np.asarray(path, dtype=np.float64), "path")
    if points.shape[-2:] == (4, 4) and points.ndim in (2, 3):
        return dict(zip(("x", "y", "z", "rx", "ry", "rz"), np.hstack(placed(points, "path")).T.tolist()))
    if points.ndim in (1, 2) and points.shape[-1] == 3 != len(robot.variables):
        return dict(zip("xyz", points.reshape(-1, 3).T.tolist()))
    joints, _ = rows(points, len(robot.variables), "path")
    return dict(zip(robot.variables, joints.T.tolist()))


def _loads(wrenches: Array, path: Mapping[str, Sequence[Any]]) -> dict[str, list[Any]]:
    """Columns of a wrench for each point of a path."""
    points = len(next(iter(path.values()), ()))
    if len(wrenches) != points:
        raise ValueError(f"wrench: {len(wrenches)} rows, and {points} points; give one of shape (6,), or one for each point")
    return dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), wrenches.T.tolist()))

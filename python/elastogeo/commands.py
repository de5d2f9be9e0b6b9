"""The commands as functions. Options that have no argument of their own are those of the command line, with ``_`` for ``-``
(``identify(.., loss_scale=2)`` is ``identify .. --loss-scale 2``), in the description's units.

All take ``progress``, which is called with a line of text between the stages and iterations of long work, and stops it by an
exception that it raises, and ``effects``, instances of :class:`Effect` in addition to those of the robot and the campaigns
given; kinds of readings of your own are the campaign's (``Campaign(.., observations=[..])``).
All raise :class:`Error` for bad input."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ._arrays import Array, finite, rows
from ._run import Progress, flags, named, numbers, run
from .campaign import Campaign, CampaignLike, columns_of, write_csv
from .effects import Effect, instances
from .observations import Observation, kinds
from .results import (
    Compensation,
    Compensator,
    Diagnosis,
    Identifiability,
    Identification,
    Placement,
    Plan,
    Report,
    Residuals,
    Sensitivity,
    Simulated,
    Stiffness,
    Track,
    View,
)
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

    :param robot: another description than the campaign's
    :param what: ``geometric``, ``elastic`` or both; by default stiffness from deflections and geometry from all other readings
    :param save: file for the calibrated description (``.yaml`` or ``.urdf``)
    :param hold: parameters to hold at their nominal values
    :param loss: ``squares``, ``huber``, ``cauchy`` or ``tukey``
    :param check: share of the configurations held out where the campaign does not say, by default 0.25
    :param force: takes what would be refused as implausible for a warning
    :param progress: called with a line of text between iterations; an exception that it raises stops the work
    :return: ``parameters``, a row for each with its ``value`` and ``ci95`` (half a 95 % interval), mm, deg, and SI of
        stiffnesses; ``rms`` of the errors by stage, mm; the names ``kept``; ``usable``
    :raises Error: bad input, or a result that is implausible (with ``force`` that is a warning)

    >>> found = identify("kr270-simulated")
    >>> found.usable, len(found.kept)
    (True, 33)
    """
    given = flags(what=what, hold=hold, loss=loss, prior=prior, check=check, seed=seed, force=force, **options)
    file = None if save is None else os.fspath(save)
    arguments = ["identify", *_campaign(campaign, robot), *given, *flags(save=file)]
    return Identification(*run(arguments, progress=progress, **_own(robot, campaign, effects=effects)), robot=file)


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
    """Where the robot stands and what its tool is: base, tool and markers fitted alone.

    :param robot: another description than the campaign's
    :param save: file for the description with base, tool and markers as found (``.yaml`` or ``.urdf``)
    :return: ``parameters`` of base, tool and markers, mm and deg, and ``rms`` of the errors by stage, mm, as of
        :func:`identify`

    >>> f"{register('kr270-simulated').rms['after']:.2f} mm"
    '0.83 mm'
    """
    given = flags(save=save, seed=seed, **options)
    arguments = ["register", *_campaign(campaign, robot), *given]
    found = run(arguments, progress=progress, **_own(robot, campaign, effects=effects))
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

    :param robot: another description than the campaign's
    :param apply: file for the description as diagnosed: calibrated, effects switched on
    :param force: takes what would be refused as implausible for a warning
    :param progress: called with a line of text between stages; an exception that it raises stops the work
    :param effects: effects of your own, which compete with those of the catalogue
    :return: ``verdict``; ``causes``, a row for each: effect, site, probability, rms before and after (mm), shrinkage (a share);
        ``sites`` with the share of the gap that could come from each
    :raises Error: bad input, or content that is implausible

    >>> found = diagnose("kr270-no-compensator")
    >>> found.verdict, found["causes"][0]["effect"], found["causes"][0]["site"]
    ('explained', 'gravity-compensator', 'joint:2')
    """
    given = flags(apply=apply, seed=seed, force=force, **options)
    arguments = ["diagnose", *_campaign(campaign, robot), *given]
    return Diagnosis(*run(arguments, progress=progress, **_own(robot, campaign, effects=effects)))


def residuals(
    robot: RobotLike,
    campaign: CampaignLike,
    *,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Residuals:
    """Compares a description with measurements, fitting nothing.

    :return: ``readings``, a row for each, and ``errors``, an array for each with a number for each coordinate: measured less
        predicted, mm (deg of angles, N.m of torques)

    >>> residuals("kuka-kr270", "kr270-simulated").errors[0].shape
    (3,)
    """
    arguments = ["residuals", named(robot), named(campaign), *flags(**options)]
    return Residuals(*run(arguments, progress=progress, **_own(robot, campaign, effects=effects)))


def identifiability(
    robot: RobotLike,
    campaign: CampaignLike,
    *,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Identifiability:
    """What a campaign can tell: rank, what is dropped and merged into what, conditioning, observability.

    :param options: of the command, for example ``what="elastic"``, ``hold=["3.d"]``, ``tolerance="noise"``
    :return: ``rank``, the names ``kept``, what is ``dropped`` and why, ``singular_values`` of shape (kept,), ``condition``;
        columns are scaled to length one, so that these have no unit

    >>> found = identifiability("kuka-kr270", "kr270-simulated")
    >>> len(found.kept), found.singular_values.shape
    (33, (33,))
    """
    arguments = ["identifiability", named(robot), named(campaign), *flags(**options)]
    return Identifiability(*run(arguments, progress=progress, **_own(robot, campaign, effects=effects)))


def sensitivity(
    robot: RobotLike,
    campaign: CampaignLike,
    *,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Sensitivity:
    """How much the tool moves per unit of each parameter, over a campaign's configurations.

    :return: ``parameters`` of the geometry, a row for each: mean and greatest displacement (m) and rotation (rad) for one m
        or rad; ``elastic``, the same for one unit of each compliance under the campaign's loads, and for its declared value

    >>> found = sensitivity("kuka-kr270", "kr270-simulated").parameters.set_index("name")
    >>> found.loc["1.d", ["position_mean", "rotation_mean"]].round(6).tolist()
    [1.0, 0.0]
    """
    arguments = ["sensitivity", named(robot), named(campaign), *flags(**options)]
    return Sensitivity(*run(arguments, progress=progress, **_own(robot, campaign, effects=effects)))


def compensator(
    *,
    circle: Any = None,
    anchor: Any = None,
    mounting: Sequence[float] | None = None,
    compliances: Any = None,
    deflections: CampaignLike | None = None,
    robot: RobotLike | None = None,
    force: bool = False,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Compensator:
    """Gravity compensator: its mounting from measured points, its spring from compliances of the joint that it unloads.

    Tables are names of files, data frames or mappings of names to columns, in mm and deg as the command's files.

    :param circle: the spring's point on the moving link at angles of the joint: columns ``q`` (deg), ``x``, ``y``, ``z`` (mm)
    :param anchor: reference points that turn about the spring's anchor: columns ``point``, ``x``, ``y``, ``z`` (mm, the same
        axes)
    :param mounting: L, ax and ay (mm), where they are known and not measured
    :param compliances: of the joint: columns ``q`` (deg), ``k2`` (1e-6 rad/(N.m)), and ``ci95``, where known
    :param deflections: a campaign of deflections at three angles of the joint or more, in the place of all that
    :param robot: another description than that of ``deflections``
    :return: ``parameters``, a row for each: name, value, ci95, unit; ``compliances`` by angle, measured and fitted

    >>> law = compensator(mounting=[184.72, 685.93, 123.3], compliances={"q": [-130, -90, -50], "k2": [0.287, 0.296, 0.295]})
    >>> law.parameters["name"].tolist()
    ['k2_0', 'kc', 's0', 'a', 'phi']
    """
    with tempfile.TemporaryDirectory(prefix="elastogeo-") as folder:
        tables = {"circle": circle, "anchor": anchor, "compliances": compliances}
        given = flags(**{name: _file(folder, name, table) for name, table in tables.items()})
        given += flags(mounting=None if mounting is None else numbers(mounting), force=force)
        if deflections is not None:
            given.append(f"--deflections={named(deflections)}")
        given += flags(robot=_named(robot if robot is not None else _own_robot(deflections)), **options)
        every = _own(robot, deflections, effects=effects)
        return Compensator(*run(["compensator", *given], progress=progress, **every))


def stiffness(
    robot: RobotLike,
    q: Joints,
    *,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: Any,
) -> Stiffness:
    """Stiffness at one configuration: :meth:`Robot.stiffness`.

    >>> stiffness("kuka-kr270", [0, -1.0, 1.5, 0, 0.3, 0], wrench=[0, 0, -2500, 0, 0, 0]).compliance.shape
    (6, 6)
    """
    return _robot(robot, effects).stiffness(q, progress=progress, **options)


def plan(
    robot: RobotLike,
    poses: int,
    *,
    wrench: npt.ArrayLike | None = None,
    seed: int = 1,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    observations: Sequence[Observation] = (),
    **options: object,
) -> Plan:
    """Chooses the configurations (and loads) to measure that leave the smallest error after compensation.

    :param poses: how many
    :param wrench: loads that can be applied, base axes, shape (6,) or (k, 6), N and N.m
    :param observations: kinds of readings of your own that ``observes=`` may name
    :return: ``joints`` of shape (poses, joints), rad and m; ``error``, expected after compensation, mm; ``bought``, what more
        configurations would leave; ``parameters`` with the ``ci95`` to expect, mm and deg, and SI of stiffnesses

    >>> plan("universal-ur5", 8).joints.shape
    (8, 6)
    """
    own = _robot(robot, effects)
    arguments = ["plan", own.source, *flags(poses=poses, seed=seed, **options), *_wrenches(own, wrench)]
    found = run(arguments, progress=progress, **_own(own, observations=observations))
    return Plan(*found, key="poses", variables=own.variables)


def compensate(
    robot: RobotLike,
    path: Any,
    *,
    nominal: RobotLike | None = None,
    wrench: npt.ArrayLike | None = None,
    start: Joints | None = None,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Compensation:
    """Commands under which the real robot passes where it should: geometry, own weight, load and effects corrected.

    :param robot: the robot as calibrated
    :param path: poses of shape (n, 4, 4) or (4, 4), positions of shape (n, 3) or (3,), m, base frame; joints of shape (n,
        joints) or (joints,), rad and m; a table with the columns of the command's path (SI); or the name of a file
    :param nominal: the description that the controller works with
    :param wrench: load of all points of shape (6,), or of each of shape (n, 6); base axes, N and N.m
    :param start: joints from which the first point is sought
    :return: ``joints`` of shape (n, joints), rad and m: the commands, nan where a point is refused; ``table`` says why it is

    >>> robot = Robot("kuka-kr270")
    >>> compensate(robot, robot.forward([0, -1.0, 1.5, 0, 0.3, 0]), wrench=[0, 0, -1000, 0, 0, 0]).joints.shape
    (1, 6)
    """
    own = _robot(robot, effects)
    with tempfile.TemporaryDirectory(prefix="elastogeo-") as folder:
        arguments = [*_along(folder, own, path, wrench, start), *flags(nominal=_named(nominal), **options)]
        found = run(["compensate", own.source, *arguments], progress=progress, **_own(nominal, own))
    return Compensation(*found, key="points", variables=own.variables)


def place(
    robot: RobotLike,
    path: Any,
    *,
    move: Mapping[str, tuple[float, float]] | None = None,
    wrench: npt.ArrayLike | None = None,
    weight: bool = False,
    least: Literal["rms", "max"] = "rms",
    start: Joints | None = None,
    seed: int = 1,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Placement:
    """Where a process deflects the arm least: the workpiece shifted and turned, and the posture of a redundant arm.

    :param path: points of the process, as of :func:`compensate`; or the name of a bundled process
    :param move: how far the workpiece may go, by name least and greatest: ``x``, ``y``, ``z`` (m) and ``rx``, ``ry``, ``rz``
        (rad, about the middle of the path), base axes; it stays where it is in what is not named
    :param wrench: load of all points of shape (6,), which does not turn with the workpiece, or of each of shape (n, 6),
        which does; base axes, N and N.m
    :param weight: counts the deflection by own weight and preloads too
    :param least: which deflection along the path is to be least
    :param start: joints from which the first point is sought
    :return: ``motion`` of shape (6,), m and rad; ``joints`` of shape (n, joints), rad and m; ``deflections``, m, as given,
        with the best posture and at the best place

    >>> best = place("kuka-ir663", "ir663-strip", process="ir663-strip", move={"x": (-0.05, 0.05)})
    >>> best.motion.round(3).tolist(), len(best.joints)
    ([-0.05, 0.0, 0.0, 0.0, 0.0, 0.0], 26)
    """
    own = _robot(robot, effects)
    with tempfile.TemporaryDirectory(prefix="elastogeo-") as folder:
        arguments = _along(folder, own, path, wrench, start)
        arguments += flags(move=_ranges(own, move), weight=weight, least=least, seed=seed, **options)
        found = run(["place", own.source, *arguments], progress=progress, effects=own.effects)
    return Placement(*found, key="points", variables=own.variables)


def simulate(
    robot: RobotLike,
    poses: int | npt.ArrayLike,
    into: str | os.PathLike[str],
    *,
    wrench: npt.ArrayLike | None = None,
    seed: int = 1,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    observations: Sequence[Observation] = (),
    **options: object,
) -> Simulated:
    """Makes a campaign from a description with drawn or given errors, in the folder ``into``: ``Campaign(into)`` reads it.

    :param poses: how many configurations to draw, or joints of shape (n, joints), rad and m
    :param wrench: loads read at each marker, base axes, shape (6,) or (k, 6), N and N.m
    :param observations: kinds of readings of your own that ``observes=`` may name
    :param options: of the command, for example ``effect="gear-ratio@joint:2:ratio=5e-4"``, ``noise=0.05`` (mm)
    :return: its ``folder``, and the ``truth``: the parameters with which it was made, SI
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
        given += _wrenches(own, wrench)
        found = run(["simulate", own.source, *given], progress=progress, **_own(own, observations=observations))
    return Simulated(*found, folder=os.fspath(into))


def report(
    campaign: CampaignLike,
    output: str | os.PathLike[str] | None = None,
    *,
    robot: RobotLike | None = None,
    certificate: bool = False,
    tolerance: float | None = None,
    seed: int = 1,
    force: bool = False,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Report:
    """A campaign in one self-contained HTML page.

    :param output: file for the page (``.html``)
    :param robot: another description than the campaign's
    :param certificate: a calibration certificate instead: errors before and after with their uncertainty, the verdict on a
        tolerance, accuracy and repeatability of poses, every reading, and what the campaign's ``certificate:`` says
    :param tolerance: greatest position error that the certificate allows, mm; by default what the campaign says
    :param force: takes what would be refused as implausible for a warning
    :return: ``html``, the page; below its keys the data of the page, for example ``found["verdict"]`` of a certificate

    >>> report("kr270-simulated", certificate=True, tolerance=0.8)["verdict"]
    'pass'
    """
    given = flags(certificate=certificate, tolerance=tolerance, seed=seed, force=force, **options)
    arguments = ["report", *_campaign(campaign, robot), *given]
    found, html = _page(arguments, output, progress, **_own(robot, campaign, effects=effects))
    return Report(*found, html=html)


def track(
    robot: RobotLike,
    campaigns: Sequence[CampaignLike],
    output: str | os.PathLike[str] | None = None,
    *,
    dates: Sequence[str | date] | None = None,
    change: Mapping[str, float] | None = None,
    a_year: float | None = None,
    alarm: Literal["last", "any"] | None = None,
    check: float | None = None,
    seed: int = 1,
    force: bool = False,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> Track:
    """Campaigns of one robot over time: what changed and when, what happened, the next check.

    :param robot: its description; where ``identify(.., save=..)`` wrote it, the reference of all checks
    :param campaigns: in the order of time
    :param output: file for the page with the control charts (``.html``)
    :param dates: days of the campaigns, as ``"2026-01-12"``; by default those of ``certificate: date`` where each campaign
        has one, else checks count as equally far apart
    :param change: changes by the parameter's name that the next check is to show, mm or deg, or SI; by default three sigmas
        of each
    :param a_year: checks in a year, over which 5 % of false alarms are spent; by default 12
    :param alarm: ``usable`` is false where the last check, or any, shows a change of the robot
    :param check: share of the configurations held out where a campaign does not say, by default 0.25
    :return: ``answer``; ``changed``; ``checks``, a row for each campaign; ``parameters``, a row for each parameter and check
        with its difference from the reference and ``ci95``, mm or deg, or SI; ``next``, the poses that the next check needs; ``html``

    >>> options = dict(errors=0, noise=0.02)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     for month, seed in (("january", 1), ("february", 2)):
    ...         made = simulate("universal-ur5", 30, f"{folder}/{month}", seed=seed, **options)
    ...     found = track("universal-ur5", [f"{folder}/january", f"{folder}/february"])
    >>> found.changed, len(found.checks)
    (False, 2)
    """
    if isinstance(campaigns, (str, os.PathLike, Campaign)):
        raise TypeError(f"`campaigns` is a list in the order of time; here {campaigns!r}")
    every = list(campaigns)
    given = flags(dates=None if dates is None else [str(day) for day in dates], change=change, a_year=a_year, alarm=alarm)
    given += flags(check=check, seed=seed, force=force, **options)
    arguments = ["track", named(robot), *map(named, every), *given]
    found, html = _page(arguments, output, progress, **_own(robot, *every, effects=effects))
    return Track(*found, html=html)


def view(
    robot: RobotLike,
    output: str | os.PathLike[str] | None = None,
    *,
    q: Joints | None = None,
    wrench: npt.ArrayLike | None = None,
    weight: bool = False,
    progress: Progress | None = None,
    effects: Sequence[Effect] = (),
    **options: object,
) -> View:
    """The robot itself in 3-D as one self-contained HTML page.

    :param output: file for the page (``.html``)
    :param q: one configuration, shape (joints,), rad and m
    :param wrench: at the tool centre point, base axes, shape (6,), N and N.m: draws the deflected shape
    :param weight: adds own weight and preloads to the deflected shape
    :param options: of the command, for example ``svg="robot.svg"``, a drawing, and ``look="-50,20"``, from where it is seen
        (deg)
    :return: ``html``, the page

    >>> "<html" in view("kuka-kr270", wrench=[0, 0, -2500, 0, 0, 0]).html
    True
    """
    own = _robot(robot, effects)
    given = flags(joints=own._joints(q), wrench=own._wrench(wrench), weight=weight, **options)
    found, html = _page(["view", own.source, *given], output, progress, **_own(own))
    return View(*found, html=html)


def _robot(robot: RobotLike, effects: Sequence[Effect] = ()) -> Robot:
    more = instances(effects)
    if isinstance(robot, Robot) and not more:
        return robot
    return Robot(named(robot), effects=_own(robot, effects=more)["effects"])


def _named(robot: RobotLike | None) -> str | None:
    return None if robot is None else named(robot)


def _own_robot(campaign: object) -> str | None:
    """The robot that a program gave a campaign in the place of its file's."""
    return campaign._given_robot if isinstance(campaign, Campaign) else None


def _campaign(campaign: CampaignLike, robot: RobotLike | None) -> list[str]:
    """A campaign and its robot as arguments."""
    return [named(campaign), *flags(robot=_named(robot if robot is not None else _own_robot(campaign)))]


def _own(*owners: object, effects: Sequence[Effect] = (), observations: Sequence[Observation] = ()) -> dict[str, Any]:
    """Effects and kinds of readings of robots and campaigns, and of a call; of one name the last."""

    def named(attribute: str, more: Sequence[Any]) -> list[Any]:
        every = [*(each for owner in owners for each in getattr(owner, attribute, ())), *more]
        return list({each.name: each for each in every}.values())

    return {
        "effects": named("effects", instances(effects)),
        "observations": named("observations", kinds(observations)),
    }


def _page(
    arguments: Sequence[str], output: str | os.PathLike[str] | None, progress: Progress | None, **own: Any
) -> tuple[tuple[dict[str, Any], str, bool], str]:
    """Runs a command that writes a page: what it found, and the page."""
    with tempfile.TemporaryDirectory(prefix="elastogeo-") as folder:
        file = os.fspath(output) if output is not None else str(Path(folder) / "page.html")
        found, text, failed = run([*arguments, f"--output={file}"], progress=progress, **own)
        if output is None:
            text = "".join(line for line in text.splitlines(keepends=True) if file not in line)
        return (found, text, failed), Path(file).read_text(encoding="utf-8")


def _file(folder: str, name: str, table: Any) -> str | None:
    """The name of a file with a table."""
    if table is None or isinstance(table, (str, os.PathLike)):
        return None if table is None else os.fspath(table)
    file = str(Path(folder) / f"{name}.csv")
    write_csv(file, columns_of(table))
    return file


def _wrenches(robot: Robot, wrench: npt.ArrayLike | None) -> list[str]:
    if wrench is None:
        return []
    given, _ = rows(wrench, 6, "wrench")
    _, _, force, torque = robot._native.units
    return [f"--wrench={numbers(each / np.array([force] * 3 + [torque] * 3))}" for each in given]


def _ranges(robot: Robot, move: Mapping[str, tuple[float, float]] | None) -> list[str] | None:
    """Ranges of a motion (SI) as the command line has them."""
    if move is None:
        return None
    if not isinstance(move, Mapping):
        raise TypeError(f"`move` maps x, y, z (m), rx, ry, rz (rad) to least and greatest values; here {move!r}")
    length, angle, _, _ = robot._native.units
    sizes = {name: angle if name.startswith("r") else length for name in move}
    return [f"{name}={float(low) / sizes[name]!r}:{float(high) / sizes[name]!r}" for name, (low, high) in move.items()]


def _along(folder: str, robot: Robot, path: Any, wrench: npt.ArrayLike | None, start: Joints | None) -> list[str]:
    """A path, its loads and its start as arguments; files that it needs are put into a folder."""
    wrenches, is_one = (None, True) if wrench is None else rows(wrench, 6, "wrench")
    given = flags(wrench=robot._wrench(wrench if is_one else None), **{"from": robot._joints(start)})
    if isinstance(path, (str, os.PathLike)):
        if not is_one:
            raise ValueError("a wrench for each point of a file stands in its columns fx, .., mz")
        return [os.fspath(path), *given]
    file = str(Path(folder) / "path.csv")
    columns = _path(robot, path) if isinstance(path, (np.ndarray, list, tuple)) else columns_of(path)
    if wrenches is not None and not is_one:
        columns |= _loads(finite(wrenches, "wrench"), columns)
    write_csv(file, columns)
    return [file, *given, *flags(units="length=m,angle=rad,force=N,torque=N.m")]


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

"""Faults are exceptions with their diagnostics; nothing panics, and Ctrl-C is heeded."""

import os
import signal
import threading
import time
from pathlib import Path
from typing import Any

import elastogeo
import numpy as np
import pytest


def test_every_fault_with_its_place(bad_campaign: Path) -> None:
    with pytest.raises(elastogeo.Error) as raised:
        elastogeo.identify(bad_campaign)
    found = raised.value.diagnostics
    assert isinstance(raised.value, ValueError) and len(found) >= 1
    errors = [each for each in found if each["severity"] == "error"]
    assert [each["line"] for each in errors] == [1, 2] and all(each["file"].endswith("m.csv") for each in errors)
    assert "`zz`" in errors[0]["remedy"] and "`one`" in errors[1]["message"]
    assert all({"code", "message", "remedy", "column"} <= set(each) for each in found)
    assert "column `z` is missing" in str(raised.value)
    with pytest.raises(elastogeo.Error):
        elastogeo.Campaign(bad_campaign)


def test_names_that_are_not_there() -> None:
    with pytest.raises(elastogeo.Error, match="kuka-kr27") as raised:
        elastogeo.Robot("kuka-kr27")
    assert "kuka-kr270" in raised.value.diagnostics[0]["remedy"]
    with pytest.raises(elastogeo.Error, match="no frame or marker"):
        elastogeo.Robot("universal-ur5").forward(np.zeros(6), at="33")
    with pytest.raises(elastogeo.Error, match="unknown parameter"):
        elastogeo.Campaign("kr270-simulated").problem(["3.dd"])
    with pytest.raises(ValueError, match="`3.d` is given twice"):
        elastogeo.Campaign("kr270-simulated").problem(["3.d", "4.d", "3.d"])
    assert elastogeo.Campaign("kr270-simulated").problem("3.d").names == ["3.d"]


def test_options_that_are_not_there() -> None:
    with pytest.raises(elastogeo.Error, match="`identify` has no argument `losss=`.*did you mean `loss=`") as raised:
        elastogeo.identify("kr270-simulated", losss="huber")
    assert raised.value.diagnostics[0]["remedy"] == "did you mean `loss=`?"
    wrong: list[tuple[Any, dict[str, Any], str]] = [
        (elastogeo.identify, {"loss_skale": 2}, "no argument `loss_skale=`.*did you mean `loss_scale=`"),
        (elastogeo.identify, {"zz": 2}, "no argument `zz=`.*elastogeo identify --help"),
        (elastogeo.identify, {"joints": 2}, "no argument `joints=`"),
        (elastogeo.diagnose, {"progres": print}, "no argument `progres=`.*did you mean `progress=`"),
        (elastogeo.identify, {"against": "x", "compare": True}, "`against=` cannot be used with `compare=`"),
        (elastogeo.identify, {"loss_scale": "two"}, "invalid value 'two' for `loss_scale=`"),
    ]
    for function, given, words in wrong:
        with pytest.raises(elastogeo.Error, match=words) as raised:
            function("kr270-simulated", **given)
        assert "Usage" not in str(raised.value)
    with pytest.raises(elastogeo.Error, match="huuber"):
        elastogeo.identify("kr270-simulated", loss="huuber")


@pytest.mark.parametrize("q", [np.zeros(5), np.zeros((2, 7)), np.zeros((2, 2, 6)), np.zeros(0), 1.0])
def test_arrays_of_wrong_shape(q: object) -> None:
    with pytest.raises(ValueError, match="shape"):
        elastogeo.Robot("universal-ur5").forward(q)  # type: ignore[arg-type]


@pytest.mark.parametrize("wrench", [1000.0, np.zeros(5), np.zeros((3, 6)), np.zeros((1, 2, 6))])
def test_wrenches_of_wrong_shape(wrench: object) -> None:
    robot = elastogeo.Robot("kuka-kr270")
    path = robot.forward(np.radians([[0, -60, 90, 0, 20, 0], [5, -60, 90, 0, 20, 0]]))
    with pytest.raises(ValueError, match="wrench: .*expected|wrench: 3 rows"):
        robot.forward(np.zeros((2, 6)), wrench=wrench)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="wrench: .*expected|wrench: 3 rows"):
        elastogeo.compensate(robot, path, wrench=wrench)  # type: ignore[arg-type]
    for single in (robot.pose, robot.stiffness):
        with pytest.raises(ValueError, match="wrench: .*expected"):
            single(np.zeros(6), wrench=wrench)  # type: ignore[arg-type]


@pytest.mark.parametrize("x", [np.arange(1.0, 7), np.zeros((2, 3)), [], np.zeros((1, 3)), 1.0])
def test_parameters_of_wrong_shape(x: object) -> None:
    problem = elastogeo.Campaign("kr270-simulated").problem(["base.x", "base.y", "base.z"])
    for function in (problem.residual, problem.jacobian):
        with pytest.raises(ValueError, match=r"x: .*expected \(3,\)"):
            function(x)  # type: ignore[arg-type]
    assert problem.residual([0, 0, 0]).shape == (486,)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_start_values_that_are_not_finite(value: float) -> None:
    with pytest.raises(elastogeo.Error, match="base.x"):
        elastogeo.Campaign("kr270-simulated").problem(["base.y"], {"base.x": value})


def test_matrices_that_are_no_poses() -> None:
    robot = elastogeo.Robot("universal-ur5")
    mirrored, sheared, shifted = np.diag([1.0, 1, -1, 1]), np.eye(4), np.eye(4)
    sheared[0, 1], shifted[3, 0] = 0.01, 1
    for wrong in (np.ones((4, 4)), mirrored, sheared, shifted, np.zeros((4, 4))):
        with pytest.raises(ValueError, match="target: the matrix is no pose"):
            robot.solve(wrong)
        with pytest.raises(ValueError, match="path: the matrix of row 1 is no pose"):
            elastogeo.compensate(robot, np.array([np.eye(4), wrong]))
    with pytest.raises(ValueError, match=r"expected \(n, 4, 4\)"):
        robot.solve(np.zeros((2, 4)))


def test_wrong_targets_and_starts() -> None:
    robot = elastogeo.Robot("universal-ur5")
    poses = robot.forward(np.full((3, 6), 0.5))
    for start in (None, {"q1": 0.0}):
        with pytest.raises(ValueError, match="start: many targets need an array"):
            robot.solve(poses, start=start)
    with pytest.raises(elastogeo.Error, match="start: 2 rows, and 3 targets"):
        robot.solve(poses, start=np.zeros((2, 6)))
    with pytest.raises(ValueError, match=r"start: .*expected \(n, 6\)"):
        robot.solve(poses, start=np.zeros(5))
    with pytest.raises(elastogeo.Error, match="row 1 .*not finite"):
        robot.solve([[0.5, 0, 0.2], [np.nan, 0, 0]], start=np.zeros(6))
    poses[1, 0, 3] = 9.0
    with pytest.raises(elastogeo.Error, match="row 1.*out of reach"):
        robot.solve(poses, start=np.full(6, 0.4), restarts=8)
    joints = robot.solve(poses, start=np.full(6, 0.4), restarts=8, unreachable="nan")
    assert np.isnan(joints).all(axis=1).tolist() == [False, True, False]


def test_robots_without_springs() -> None:
    robot = elastogeo.Robot("universal-ur5")
    for compliance in (robot.compliance, robot.stiffness):
        with pytest.raises(elastogeo.Error, match="nothing elastic") as raised:
            compliance(np.zeros(6))
        assert "joint_stiffness" in raised.value.diagnostics[0]["remedy"]


def test_numbers_that_are_not_finite() -> None:
    robot = elastogeo.Robot("kuka-ir663")
    for value in (np.nan, np.inf):
        q = np.zeros((3, 6))
        q[1, 2] = value
        with pytest.raises(elastogeo.Error, match="row 1"):
            robot.forward(q)
    with pytest.raises(elastogeo.Error):
        robot.forward(np.full(6, 100.0))
    assert robot.forward(np.zeros((0, 6))).shape == (0, 4, 4)


def test_arrays_for_files_are_finite(tmp_path: Path) -> None:
    q = np.zeros((3, 6))
    q[2, 1] = np.nan
    with pytest.raises(ValueError, match="row 2"):
        elastogeo.simulate("universal-ur5", q, tmp_path / "trial")
    with pytest.raises(ValueError, match="row 2"):
        elastogeo.compensate("universal-ur5", q)


def test_a_hook_that_raises_stops_the_work(tmp_path: Path) -> None:
    def stop(_: str) -> None:
        raise RuntimeError("enough")

    file = tmp_path / "diagnosed.yaml"
    with pytest.raises(RuntimeError, match="enough"):
        elastogeo.diagnose("kr270-no-compensator", apply=file, progress=stop)
    # Nor is anything written later: the same call takes longer than what is left of that one.
    elastogeo.diagnose("kr270-no-compensator")
    assert not file.exists()


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_is_heeded() -> None:
    def press() -> None:
        time.sleep(0.3)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=press).start()
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(100):
            elastogeo.diagnose("kr270-no-compensator")
    assert time.monotonic() - started < 3


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("name", ["forward", "jacobian", "compliance", "sag"])
def test_ctrl_c_is_heeded_by_functions_of_arrays(name: str) -> None:
    robot = elastogeo.Robot("kuka-ir663")
    low, high = robot.limits.T
    q = np.tile((low + high) / 2, (20_000, 1))
    work = {"sag": lambda q: robot.forward(q, weight=True)}.get(name) or getattr(robot, name)
    started = time.monotonic()
    work(q)
    took = time.monotonic() - started
    # Some seconds, in which other programs that take the processors for a moment do not count.
    times = min(50, 1 + int(3 / took))
    q, whole = np.tile(q, (times, 1)), times * took
    heard = time.monotonic()

    def press() -> None:
        nonlocal heard
        time.sleep(took / 2)
        heard = time.monotonic()
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=press)
    with pytest.raises(KeyboardInterrupt):
        thread.start()
        for _ in range(100):
            work(q)
    heeded = time.monotonic() - heard
    thread.join()
    print(f"{name}: {whole:.2f} s of work, Ctrl-C heeded after {heeded:.3f} s")
    assert heeded < 0.4 * whole


def test_the_lock_is_free_meanwhile() -> None:
    turns = 0
    done = threading.Event()

    def count() -> None:
        nonlocal turns
        while not done.is_set():
            turns += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    elastogeo.diagnose("kr270-no-compensator")
    done.set()
    thread.join()
    assert turns > 50

"""Faults are exceptions with their diagnostics; nothing panics, and Ctrl-C is heeded."""

import os
import signal
import threading
import time
from pathlib import Path

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


def test_options_that_are_not_there() -> None:
    with pytest.raises(elastogeo.Error, match="--losss"):
        elastogeo.identify("kr270-simulated", losss="huber")
    with pytest.raises(elastogeo.Error, match="huuber"):
        elastogeo.identify("kr270-simulated", loss="huuber")


@pytest.mark.parametrize("q", [np.zeros(5), np.zeros((2, 7)), np.zeros((2, 2, 6)), np.zeros(0), 1.0])
def test_arrays_of_wrong_shape(q: object) -> None:
    with pytest.raises(ValueError, match="shape"):
        elastogeo.Robot("universal-ur5").forward(q)  # type: ignore[arg-type]


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

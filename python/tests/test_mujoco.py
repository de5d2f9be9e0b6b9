"""Descriptions written as MJCF, in MuJoCo itself: frames, closed loops, couplings, and the sag under own weight."""

import math
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from conftest import Command

mujoco = pytest.importorskip("mujoco")

ROBOTS = [
    "universal-ur5",
    "kuka-kr270",
    "kuka-ir663",
    "barrett-wam",
    "franka-panda",
    "scara-rail",
    "palletiser",
    "five-bar",
    "hexapod",
]


def joints(variables: list[dict[str, Any]], seed: int) -> str:
    """A configuration near the middle of the limits, in deg and mm."""
    draw = random.Random(seed)

    def one(variable: dict[str, Any]) -> str:
        low, high = variable.get("limits") or [-0.3, 0.3]
        value = 0.5 * (low + high) + 0.2 * (high - low) * (draw.random() - 0.5)
        return f"{variable['name']}={math.degrees(value) if variable['unit'] == 'rad' else 1e3 * value:.3f}"

    return ",".join(one(variable) for variable in variables)


def loaded(command: Command, robot: str, path: Path) -> tuple[Any, Any]:
    command("convert", robot, str(path), "--as", "mjcf")
    model = mujoco.MjModel.from_xml_path(str(path))
    return model, mujoco.MjData(model)


@pytest.mark.parametrize("robot", ROBOTS)
def test_frames_and_loops(command: Command, robot: str, tmp_path: Path) -> None:
    model, data = loaded(command, robot, tmp_path / "robot.xml")
    variables = command("check", robot)["variables"]
    for seed in range(3):
        pose = command("pose", robot, "--joints", joints(variables, seed))
        for name, value in pose["joints"].items():
            data.joint(name).qpos[0] = value
        mujoco.mj_forward(model, data)
        for name, frame in pose["frames"].items():
            if name != "0":
                wanted = np.array(frame)
                assert np.abs(data.body(name).xpos - wanted[:3, 3]).max() < 1e-9
                assert np.abs(data.body(name).xmat.reshape(3, 3) - wanted[:3, :3]).max() < 1e-9
        for name, place in pose["markers"].items():
            assert np.abs(data.site(name).xpos - np.array(place)).max() < 1e-9
        # Loops and couplings hold: MuJoCo sees no violation.
        assert data.ne == 0 or np.abs(data.efc_pos[: data.ne]).max() < 1e-9


def test_sag_under_own_weight(command: Command, tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    command("convert", "kuka-kr270", str(path))
    robot = yaml.safe_load(path.read_text())
    # Its compensator acts on the stiffness alone, which MuJoCo cannot hold.
    del robot["springs"]
    robot.pop("calibration", None)
    path.write_text(yaml.safe_dump(robot, sort_keys=False))
    model, data = loaded(command, str(path), tmp_path / "robot.xml")
    at = "q1=20,q2=-60,q3=80,q4=30,q5=40,q6=10"
    rigid = command("pose", str(path), "--joints", at)
    heavy = command("pose", str(path), "--joints", at, "--weight")
    for name, value in rigid["joints"].items():
        data.joint(name).qpos[0] = value
    mujoco.mj_forward(model, data)
    before = data.site("m1").xpos.copy()
    # Where each spring balances gravity.
    for joint in np.flatnonzero(model.jnt_stiffness > 0):
        bias = data.qfrc_bias[model.jnt_dofadr[joint]]
        data.qpos[model.jnt_qposadr[joint]] = -bias / model.jnt_stiffness[joint]
    mujoco.mj_kinematics(model, data)
    sag = data.site("m1").xpos - before
    expected = np.array(heavy["markers"]["m1"]) - np.array(rigid["markers"]["m1"])
    assert np.linalg.norm(expected) > 1e-3
    assert np.linalg.norm(sag - expected) < 0.01 * np.linalg.norm(expected)


def test_what_is_lost_is_said(command: Command, tmp_path: Path) -> None:
    said = command("convert", "kuka-ir663", str(tmp_path / "robot.xml"), "--as", "mjcf")["diagnostics"]
    assert "`screw2`" in said[0]["message"] and "beams" in said[0]["message"]

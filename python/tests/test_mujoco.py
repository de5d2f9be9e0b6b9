"""Descriptions written as MJCF, in MuJoCo itself: frames, loops, couplings; stepped to rest: own weight, effects of joints."""

import doctest
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


def without(*keys: str) -> dict[str, Any]:
    return {key: None for key in keys}


def masses(mass: float, *bodies: str | int) -> dict[Any, Any]:
    return {body: {"mass": mass} for body in bodies}


KR270 = without("springs", "calibration")  # its compensator acts on the stiffness alone, which MuJoCo cannot hold
LINKS = masses(20.0, 2, 3, "wrist", "flange", "crank", "rod", "triangle", "lower-rod", "upper-rod", 1)
SCREWS = {"screw2": {"axial": {"value": 2e5}}, "screw8": {"axial": {"value": 2e5}}}
IR663 = without("beams", "sections", "materials", "calibration") | {
    "bodies": {body: {"mass": 100.0, "com": [100, 0, 0]} for body in (1, 2, 3, 4, 5, 6, 7, 8, 9)}
}

# Robot, what is changed in its description (gravity and masses in its units), and the configuration, deg and mm.
LOADED = {
    "KR-270": ("kuka-kr270", KR270, "q1=20,q2=-60,q3=80,q4=30,q5=40,q6=10"),
    "KR-270 on a soft pedestal": (
        "kuka-kr270",
        KR270 | {"base_stiffness": {"kz": {"value": 5e7}, "krx": {"value": 1e7}, "kry": {"value": 2e7}}},
        "q1=-30,q2=-80,q3=100,q4=-30,q5=60,q6=10",
    ),
    "palletiser, 1 kg": ("palletiser", {"bodies": masses(1.0, "flange")}, "q1=10,q2=20,q3=20,q4=30"),
    "palletiser, heavy links": ("palletiser", {"bodies": LINKS}, "q1=10,q2=20,q3=20,q4=30"),
    "five-bar": (
        "five-bar",
        {
            "gravity": [0, -9.81, 0],
            "bodies": {body: {"mass": 2.0, "com": [100, 0, 0]} for body in ("a1", "a2", "b1", "b2")},
        },
        "q1=110,q2=65",
    ),
    "hexapod": (
        "hexapod",
        {
            "bodies": {"platform": {"mass": 100.0, "com": [10, 20, 30]}}
            | {f"p{leg}": {"mass": 10.0, "com": [0, 0, -200]} for leg in range(1, 7)}
        },
        "s1=100,s2=120,s3=110,s4=130,s5=90,s6=115",
    ),
    "IR663": ("kuka-ir663", IR663, "q1=20,stroke2=800,stroke8=800,q4=30,q5=60,q7=10"),
    "IR663, soft screws": (
        "kuka-ir663",
        IR663 | {"actuators": SCREWS},
        "q1=20,stroke2=800,stroke8=800,q4=30,q5=60,q7=10",
    ),
}


def changed(command: Command, robot: str, changes: dict[Any, Any], path: Path) -> str:
    """A bundled description with keys replaced; `None` takes one out, a mapping is merged."""

    def merged(old: dict[Any, Any], new: dict[Any, Any]) -> dict[Any, Any]:
        both = old | {
            key: merged(old[key], value) if isinstance(value, dict) and isinstance(old.get(key), dict) else value
            for key, value in new.items()
        }
        return {key: value for key, value in both.items() if value is not None}

    command("convert", robot, str(path))
    path.write_text(yaml.safe_dump(merged(yaml.safe_load(path.read_text()), changes), sort_keys=False))
    return str(path)


def points(model: Any, data: Any) -> dict[str, Any]:
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SITE, site) for site in range(model.nsite)]
    return {name: data.site(name).xpos.copy() for name in names}


def wanted(pose: dict[str, Any]) -> dict[str, Any]:
    """Markers and tool of a pose, m."""
    return {name: np.array(at) for name, at in pose["markers"].items()} | {"TCP": np.array(pose["tool"])[:3, 3]}


def at_rest(command: Command, robot: str, at: str, path: Path) -> tuple[dict[str, Any], Any]:
    """Points of the model driven from its keyframe to a configuration and left until it rests, and the greatest violation."""
    model, data = loaded(command, robot, path)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    sizes = {own["name"]: math.radians(1.0) if own["unit"] == "rad" else 1e-3 for own in command("check", robot)["variables"]}
    for name, value in (each.split("=") for each in at.split(",")):
        data.actuator(name).ctrl[0] = float(value) * sizes[name]
    mujoco.mj_step(model, data, 6000)
    assert np.abs(data.qvel).max() < 1e-7
    mujoco.mj_forward(model, data)
    return points(model, data), np.abs(data.efc_pos[: data.ne]).max() if data.ne else 0.0


@pytest.mark.parametrize("case", LOADED)
def test_sag_under_own_weight(command: Command, case: str, tmp_path: Path) -> None:
    bundled, changes, at = LOADED[case]
    robot = changed(command, bundled, changes, tmp_path / "robot.yaml")
    rigid = wanted(command("pose", robot, "--joints", at))
    heavy = wanted(command("pose", robot, "--joints", at, "--weight"))
    found, violation = at_rest(command, robot, at, tmp_path / "robot.xml")
    assert violation < 1e-6
    for name, place in rigid.items():
        expected, sag = heavy[name] - place, found[name] - place
        assert np.linalg.norm(expected) > 1e-6
        assert np.linalg.norm(sag - expected) < 0.01 * np.linalg.norm(expected)


def test_links_beside_each_other(command: Command, tmp_path: Path) -> None:
    robot = changed(command, "five-bar", {"frames": {"b2": {"r": 25}}, "limits": None}, tmp_path / "robot.yaml")
    pose = command("pose", robot, "--joints", "q1=110,q2=65")
    said = command("convert", robot, str(tmp_path / "robot.xml"), "--as", "mjcf")
    assert said["diagnostics"] == []
    found, violation = at_rest(command, robot, "q1=110,q2=65", tmp_path / "robot.xml")
    assert violation < 1e-9 and np.linalg.norm(found["TCP"] - wanted(pose)["TCP"]) < 1e-9


@pytest.mark.parametrize("bodies", [LINKS, masses(100.0, 1)])
def test_rigid_loops_stand(command: Command, bodies: dict[str, Any], tmp_path: Path) -> None:
    changes = {"bodies": bodies} | without("joint_stiffness")
    robot = changed(command, "palletiser", changes, tmp_path / "robot.yaml")
    at = "q1=10,q2=20,q3=20,q4=30"
    rigid = wanted(command("pose", robot, "--joints", at))
    found, violation = at_rest(command, robot, at, tmp_path / "robot.xml")
    assert violation < 1e-7
    assert all(np.linalg.norm(found[name] - place) < 1e-6 for name, place in rigid.items())


EFFECTS = [
    ("kuka-kr270", "joint-offset", "joint:2", {"2.theta": 1e-3}, "q1=20,q2=-60,q3=80,q4=30,q5=40,q6=10"),
    ("kuka-kr270", "gear-ratio", "joint:3", {"ratio": 1e-5}, "q1=20,q2=-60,q3=80,q4=30,q5=40,q6=10"),
    ("palletiser", "joint-offset", "joint:crank", {"crank.theta": 1e-3}, "q1=10,q2=20,q3=20,q4=30"),
    ("palletiser", "gear-ratio", "joint:2", {"ratio": 1e-5}, "q1=10,q2=20,q3=20,q4=30"),
    ("scara-rail", "gear-ratio", "joint:carriage", {"ratio": 1e-3}, "rail=1500,q1=20,q2=30,down=50,q4=10"),
    ("kuka-ir663", "joint-offset", "joint:2", {"screw2.stroke": 1e-3}, "q1=20,stroke2=800,stroke8=800,q4=30,q5=60,q7=10"),
]


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize(("bundled", "effect", "site", "parameters", "at"), EFFECTS)
def test_effects_of_actuated_joints(
    command: Command, bundled: str, effect: str, site: str, parameters: dict[str, float], at: str, direction: int, tmp_path: Path
) -> None:
    entry = {"effect": effect, "site": site, "parameters": parameters}
    changes = {"effects": [entry]} | without("bodies", "springs", "beams", "sections", "materials", "calibration")
    frame = site.partition(":")[2]
    if direction < 0:
        if "screw" in str(parameters):
            pytest.skip("a stroke has no direction")
        changes["frames"] = {frame: {"direction": direction, "limits": None}}
    robot = changed(command, bundled, changes, tmp_path / "robot.yaml")
    found, _ = at_rest(command, robot, at, tmp_path / "robot.xml")
    moved = wanted(command("pose", robot, "--joints", at, "--weight"))
    assert all(np.linalg.norm(found[name] - place) < 1e-9 for name, place in moved.items())
    rigid = wanted(command("pose", robot, "--joints", at))
    assert np.linalg.norm(moved["TCP"] - rigid["TCP"]) > 1e-6


def test_what_is_lost_is_said(command: Command, tmp_path: Path) -> None:
    said = command("convert", "kuka-ir663", str(tmp_path / "robot.xml"), "--as", "mjcf")["diagnostics"]
    assert "beams (`b1`" in said[0]["message"] and "screw" not in said[0]["message"]


def test_the_page_on_simulation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    page = Path(__file__).parents[2] / "docs/simulation.md"
    found = doctest.testfile(str(page), module_relative=False)
    assert found.attempted > 20 and found.failed == 0

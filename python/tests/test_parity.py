"""What Python finds is what the command prints."""

from pathlib import Path
from typing import Any

import elastogeo
import numpy as np
import pytest
from conftest import Command


def timeless(found: Any) -> Any:
    """Without the seconds that it took."""
    if isinstance(found, dict):
        return {key: timeless(value) for key, value in found.items() if key != "seconds"}
    return [timeless(each) for each in found] if isinstance(found, list) else found


ROOT = Path(__file__).parents[2]
BUNDLED = sorted(path.name for path in (ROOT / "campaigns").iterdir() if path.is_dir())


@pytest.mark.parametrize("campaign", BUNDLED)
@pytest.mark.parametrize("name", ["identify", "diagnose", "register"])
def test_every_bundled_campaign(name: str, campaign: str, command: Command) -> None:
    wanted = command(name, campaign)
    try:
        found = getattr(elastogeo, name)(campaign)
    except elastogeo.Error as error:
        # What the command refuses is refused with the same diagnostics.
        assert set(wanted) == {"diagnostics"}
        words = [[each[key] for each in error.diagnostics] for key in ("code", "message", "remedy")]
        assert words == [[each[key] for each in wanted["diagnostics"]] for key in ("code", "message", "remedy")]
    else:
        assert timeless(found.to_dict()) == timeless(wanted)


@pytest.mark.parametrize("campaign", ["kr270-simulated", "kr270-no-compensator", "ir663-simulated"])
def test_identify(campaign: str) -> None:
    found = elastogeo.identify(campaign)
    assert found.usable and len(found.parameters) == found["columns"]
    assert found._repr_html_().index("mm calibrated") < found._repr_html_().index("<svg")
    assert "<svg" in found._repr_html_() and "<table" in found._repr_html_()


def test_identify_with_options(command: Command) -> None:
    found = elastogeo.identify("kr270-simulated", hold=["3.d", "4.r"], loss="huber", loss_scale=2, seed=3)
    wanted = command("identify", "kr270-simulated", "--hold=3.d,4.r", "--loss=huber", "--loss-scale=2", "--seed=3")
    assert timeless(found.to_dict()) == timeless(wanted)
    assert "3.d" not in found.kept


def test_schemes_side_by_side(command: Command) -> None:
    found = elastogeo.identify("kr270-simulated", compare=True)
    assert timeless(found.to_dict()) == timeless(command("identify", "kr270-simulated", "--compare"))
    assert "<pre>" in found._repr_html_()


def test_diagnose() -> None:
    told: list[str] = []
    found = elastogeo.diagnose("kr270-rigid-joint-1", progress=told.append)
    assert found.verdict == "explained" and len(found.causes) > 0 and len(told) > 3
    assert "<svg" in found._repr_html_()


def test_residuals(command: Command) -> None:
    left = elastogeo.residuals("kuka-kr270", "kr270-simulated")
    assert left.to_dict() == command("residuals", "kuka-kr270", "kr270-simulated")
    assert len(left.readings) == 270 and left.errors[0].shape == (3,) and "<svg" in left._repr_html_()


def test_identifiability_and_check(command: Command) -> None:
    found = elastogeo.identifiability("kuka-ir663", "ir663-paper-poses")
    assert found.to_dict() == command("identifiability", "kuka-ir663", "ir663-paper-poses")
    assert elastogeo.Robot("kuka-ir663").check().to_dict() == command("check", "kuka-ir663")


def test_pose_and_forward(command: Command) -> None:
    q = np.radians([30.0, -60.0, 90.0, 0.0, 0.0, 0.0])
    robot = elastogeo.Robot("universal-ur5")
    wanted = command("pose", "universal-ur5", "--joints=q1=30,q2=-60,q3=90")
    assert np.allclose(robot.pose(q)["tool"], wanted["tool"], atol=1e-14)
    assert np.allclose(robot.forward(q), wanted["tool"], atol=1e-14)
    assert np.allclose(robot.forward(q, at="3"), wanted["frames"]["3"], atol=1e-14)


def test_pose_under_load(command: Command) -> None:
    robot = elastogeo.Robot("kuka-kr270")
    q, wrench = np.radians([0, -60, 90, 0, 20, 0]), [0.0, 0, -2500, 0, 0, 0]
    joints = "--joints=" + ",".join(f"{name}={value!r}" for name, value in zip(robot.variables, np.degrees(q).tolist()))
    wanted = command("pose", "kuka-kr270", joints, "--wrench=0,0,-2500,0,0,0", "--weight")
    assert np.allclose(robot.forward(q, wrench=wrench), wanted["tool"], atol=1e-12)
    marker = robot.markers[0]
    assert np.allclose(robot.forward(q, wrench=wrench, at=marker)[:3, 3], wanted["markers"][marker], atol=1e-12)
    assert np.linalg.norm(robot.forward(q, wrench=wrench)[:3, 3] - robot.forward(q)[:3, 3]) > 1e-4


def test_stiffness(command: Command) -> None:
    robot, q = elastogeo.Robot("kuka-kr270"), np.radians([0, -60, 90, 0, 20, 0])
    joints = ",".join(f"{name}={value!r}" for name, value in zip(robot.variables, np.degrees(q).tolist()))
    wanted = command("stiffness", "kuka-kr270", f"--joints={joints}", "--wrench=0,0,-2500,0,0,0")
    found = elastogeo.stiffness(robot, q, wrench=[0, 0, -2500, 0, 0, 0])
    assert np.allclose(found.compliance, wanted["compliance"], rtol=1e-12)
    assert np.allclose(robot.compliance(q), wanted["compliance"], rtol=1e-10, atol=1e-18)
    assert found.shares == pytest.approx(wanted["shares"])


@pytest.mark.parametrize("name", ["universal-ur5", "kuka-ir663", "palletiser"])
def test_jacobian_is_the_derivative(name: str) -> None:
    robot = elastogeo.Robot(name)
    limits = np.clip(robot.limits, -1, 1) if np.isinf(robot.limits).any() else robot.limits
    q = limits.mean(axis=1)
    step, found = 1e-6, robot.jacobian(q)
    for k in range(len(q)):
        moved = np.zeros(len(q))
        moved[k] = step
        after, before = robot.forward(q + moved), robot.forward(q - moved)
        assert np.allclose((after - before)[:3, 3] / (2 * step), found[:3, k], atol=1e-7)
        turned = elastogeo.rotation_vector(after[:3, :3] @ before[:3, :3].T) / (2 * step)
        assert np.allclose(turned, found[3:, k], atol=1e-7)


def test_one_wrench_for_each_configuration() -> None:
    robot = elastogeo.Robot("kuka-kr270")
    q = np.radians([[0, -60, 90, 0, 20, 0], [30, -60, 90, 0, 20, 0]])
    wrenches = np.array([[0, 0, -2500, 0, 0, 0], [500, 0, 0, 0, 90, 0]])
    found = robot.forward(q, wrench=wrenches)
    for k, wrench in enumerate(wrenches):
        assert np.array_equal(found[k], robot.forward(q[k], wrench=wrench))
        assert np.array_equal(found[k], robot.forward(q, wrench=wrench)[k])
    assert np.array_equal(robot.forward(q.tolist(), weight=True), robot.forward(np.asfortranarray(q), wrench=np.zeros(6)))


def test_what_a_call_leaves_behind_is_of_its_point() -> None:
    """Workspaces of a point are not used for another."""
    q = np.radians([0, -60, 90, 0, 20, 0])
    wanted = {
        (name, at): getattr(elastogeo.Robot("kuka-kr270"), name)(q, at=at)
        for name in ("jacobian", "compliance") for at in (None, "3", "m1")
    }  # fmt: skip
    robot = elastogeo.Robot("kuka-kr270")
    for (name, at), found in [*wanted.items()] * 2:
        assert np.array_equal(getattr(robot, name)(q, at=at), found)
    assert not np.allclose(wanted["jacobian", "3"], wanted["jacobian", None])


@pytest.mark.parametrize("name", ["universal-ur5", "kuka-kr270"])
def test_compliance_by_rules_is_that_of_the_command(name: str, tmp_path: Any) -> None:
    file = tmp_path / "by-rules.yaml"
    elastogeo.Robot(name).convert(file)
    adds = "true" if name == "kuka-kr270" else "false"
    rules = "x.fx: {modes: [[-24, 37], [33, 63]], conclusions: [1e-3, 2e-3, 1e-3, 3e-3]}"
    file.write_text(file.read_text() + f"\nfuzzy: {{inputs: [q2, q3], adds: {adds}, components: {{{rules}}}}}\n")
    robot = elastogeo.Robot(file)
    q = np.radians([[0, -20, 40, 0, 20, 0], [0, 20, 60, 0, 20, 0]])
    found = robot.compliance(q)
    assert not np.allclose(found[0], found[1], rtol=0.1, atol=0)
    for one, compliance in zip(q, found):
        assert np.allclose(robot.stiffness(one).compliance, compliance, rtol=1e-10, atol=1e-18)


def test_errors_of_angles_alone(tmp_path: Any, command: Command) -> None:
    (tmp_path / "level.yaml").write_text(
        "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: inclination\ninstrument: {orientation: 0.002}\n"
        "calibrate: [geometry, joint-offset]\nmeasurements:\n- {file: forearm.csv, body: '3', mount: unknown}\n"
        "- {file: flange.csv}\n"
    )
    command("simulate", str(tmp_path / "level.yaml"), "--poses=40", "--seed=6", f"--into={tmp_path / 'trial'}")
    found = elastogeo.identify(tmp_path / "trial")
    stages = found["residuals"]
    assert found.unit == "deg" and all(found.rms[stage] for stage in ("before", "after"))
    of = stages["check_after"] or stages["after"]
    assert found.rms["after"] == of["orientation"]["rms"] > 0 and "rms, deg" in found._repr_html_()


def test_many_configurations_are_single_ones() -> None:
    robot = elastogeo.Robot("kuka-ir663")
    low, high = robot.limits.T
    q = np.random.default_rng(1).uniform(0.7 * low + 0.3 * high, 0.3 * low + 0.7 * high, (1500, len(low)))
    poses, compliances = robot.forward(q), robot.compliance(q[:600])
    for k in (0, 511, 512, 1499):
        assert np.array_equal(poses[k], robot.forward(q[k]))
    assert np.array_equal(compliances[550], robot.compliance(q[550]))


def test_plan_compensate_simulate_report(tmp_path: Any, command: Command) -> None:
    planned = elastogeo.plan("universal-ur5", 8)
    assert timeless(planned.to_dict()) == timeless(command("plan", "universal-ur5", "--poses=8"))
    assert planned.joints.shape == (8, 6)

    path = elastogeo.compensate("kuka-ir663", "ir663-strip", process="ir663-strip")
    assert path.to_dict() == command("compensate", "kuka-ir663", "ir663-strip", "--process=ir663-strip")
    robot = elastogeo.Robot("kuka-kr270")
    q = np.radians([[0, -60, 90, 0, 20, 0], [5, -60, 90, 0, 20, 0]])
    wrench = [0, 0, -1000, 0, 0, 0]
    corrected = elastogeo.compensate(robot, robot.forward(q), wrench=wrench, start=q[0])
    assert corrected.usable and np.allclose(robot.forward(corrected.joints, wrench=wrench), robot.forward(q), atol=1e-6)

    # A load for each point, and a single pose.
    loads = [wrench, [300, 0, -500, 0, 0, 0]]
    each = elastogeo.compensate(robot, robot.forward(q), wrench=loads, start=q[0])
    assert np.allclose(robot.forward(each.joints, wrench=loads), robot.forward(q), atol=1e-6)
    assert np.allclose(each.joints[0], corrected.joints[0], atol=1e-9) and not np.allclose(each.joints[1], corrected.joints[1])
    single = elastogeo.compensate(robot, robot.forward(q[0]), wrench=wrench, start=q[0])
    assert np.allclose(single.joints, corrected.joints[:1], atol=1e-9)

    made = elastogeo.simulate("universal-ur5", planned.joints, tmp_path / "trial", noise=0.01)
    assert len(elastogeo.Campaign(made.folder)) == 8 and {"name", "true"} <= set(made.truth.columns)
    page = elastogeo.report("kr270-rigid-joint-1", tmp_path / "page.html")
    assert page.html == (tmp_path / "page.html").read_text() and "srcdoc" in page._repr_html_()


def test_a_refused_point_leaves_the_others() -> None:
    robot = elastogeo.Robot("universal-ur5")
    path = robot.forward(np.full((3, 6), 0.5))
    path[1, :3, 3] = [5, 0, 0]
    found = elastogeo.compensate(robot, path, start=[0.5] * 6)
    assert not found.usable and np.isnan(found.joints).all(axis=1).tolist() == [False, True, False]
    assert np.allclose(found.joints[::2], 0.5)
    assert found.table["q1"].isna().tolist() == [False, True, False] and "joints" not in found.table
    assert found.table["status"][0] == "ok" and "out of reach" in found.table["status"][1]
    assert "out of reach" in found._repr_html_()


def test_solve() -> None:
    robot = elastogeo.Robot("universal-ur5")
    q = np.array([0.3, -1.0, 1.2, 0.2, 0.5, 0.1])
    every = robot.solve(robot.forward(q))
    assert len(every) == 8 and np.allclose(robot.forward(every), robot.forward(q), atol=1e-9)
    assert any(np.allclose(each, q) for each in every)


@pytest.mark.parametrize("name", ["kuka-kr270", "kuka-ir663"])
def test_solve_many_as_one_by_one(name: str) -> None:
    robot = elastogeo.Robot(name)
    middle = robot.limits.mean(axis=1)
    middle[4] += 0.8  # where the wrist is not singular
    q = middle + 0.1 * (robot.limits[:, 1] - robot.limits.mean(axis=1)) * np.random.default_rng(3).uniform(-1, 1, (70, len(middle)))
    for weight in (False, True):
        poses = robot.forward(q, weight=weight)
        many = robot.solve(poses, start=q + 0.01, restarts=0, weight=weight)
        assert np.abs(robot.forward(many, weight=weight) - poses).max() < 1e-9
        one = robot.solve(poses[5], start=q[5] + 0.01, restarts=0, weight=weight)
        assert np.allclose(one, many[5:6], rtol=0, atol=1e-12)  # the command's joints went through deg and mm
    places = robot.solve(poses[:, :3, 3], start=q, restarts=0)
    assert np.abs(robot.forward(places)[:, :3, 3] - poses[:, :3, 3]).max() < 1e-9

"""Against Pinocchio: the exported URDF, and how fast."""

import time
from pathlib import Path

import elastogeo
import numpy as np
import pytest

pinocchio = pytest.importorskip("pinocchio")


@pytest.mark.parametrize("name", ["universal-ur5", "kuka-kr270", "franka-panda"])
def test_the_exported_urdf_leads_to_the_same_poses(name: str, tmp_path: Path) -> None:
    robot = elastogeo.Robot(name)
    robot.convert(tmp_path / "robot.urdf")
    model = pinocchio.buildModelFromUrdf(str(tmp_path / "robot.urdf"))
    data = model.createData()
    q = np.random.default_rng(1).uniform(-1, 1, (200, len(robot.variables)))
    low, high = robot.limits.T
    q = np.clip(q, np.maximum(low, -1e3), np.minimum(high, 1e3))
    ours, names = robot.forward(q), [frame.name for frame in model.frames]
    tool = names.index("tool") if "tool" in names else len(names) - 1
    greatest = 0.0
    for joints, pose in zip(q, ours):
        pinocchio.framesForwardKinematics(model, data, joints)
        theirs = data.oMf[tool].homogeneous
        greatest = max(greatest, float(np.abs(theirs - pose).max()))
    print(f"{name}: greatest difference to Pinocchio {greatest:.1e}")
    assert greatest < 1e-12


def test_speed(tmp_path: Path) -> None:
    """Printed, not asserted: machines differ."""
    robot = elastogeo.Robot("universal-ur5")
    robot.convert(tmp_path / "robot.urdf")
    model = pinocchio.buildModelFromUrdf(str(tmp_path / "robot.urdf"))
    data = model.createData()
    q = np.random.default_rng(1).uniform(-1, 1, (100_000, 6))
    one = q[0]

    def best(work: object, count: int) -> float:
        times = []
        for _ in range(5):
            started = time.perf_counter()
            work()  # type: ignore[operator]
            times.append(time.perf_counter() - started)
        return min(times) / count

    def loop() -> None:
        for joints in q[:10_000]:
            pinocchio.framesForwardKinematics(model, data, joints)

    def single() -> None:
        for _ in range(10_000):
            robot.forward(one)

    ours, theirs, call = best(lambda: robot.forward(q), len(q)), best(loop, 10_000), best(single, 10_000)
    print(
        f"UR5 poses: {1e6 * ours:.3f} us each in an array of 100000, {1e6 * theirs:.3f} us by Pinocchio's loop in Python "
        f"(ratio {theirs / ours:.1f}); a single call {1e6 * call:.2f} us"
    )

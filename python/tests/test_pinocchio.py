"""Against Pinocchio: the exported URDF. How fast both are: `python/benches/calls.py`."""

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

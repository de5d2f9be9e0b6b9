"""Time of the functions of arrays: of a configuration in an array, and of a single call, one thread; poses and Jacobians of the
exported URDF by Pinocchio in the same run (`pip install pin`). The best of several runs is printed. Exit status 1: what a call costs
beyond the configuration itself is more than MOST of Pinocchio's calls.

    python python/benches/calls.py
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ["RAYON_NUM_THREADS"] = "1"  # read when the package is first used

import elastogeo
import numpy as np

#: Configurations of the arrays, and calls one after another.
ROWS, CALLS = 20_000, 2_000
REPEATS = 15
#: A ratio, because machines differ: measured were 1.4 to 2.5.
MOST = 5.0


def best(work: Callable[[], object], count: int) -> float:
    """Microseconds of one of `count`."""
    times = []
    for _ in range(REPEATS):
        started = time.perf_counter()
        work()
        times.append(time.perf_counter() - started)
    return 1e6 * min(times) / count


def theirs(robot: elastogeo.Robot, q: Any) -> dict[str, float]:
    """Microseconds of Pinocchio's functions, called from Python one configuration after another."""
    try:
        import pinocchio
    except ImportError:
        print("skipped: Pinocchio is not installed")
        return {}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "robot.urdf"
        robot.convert(file)
        model = pinocchio.buildModelFromUrdf(str(file))
    data, last = model.createData(), model.nframes - 1
    q = q[:CALLS]

    def forward() -> None:
        for joints in q:
            pinocchio.framesForwardKinematics(model, data, joints)

    def jacobian() -> None:
        for joints in q:
            pinocchio.computeFrameJacobian(model, data, joints, last, pinocchio.LOCAL_WORLD_ALIGNED)

    return {"forward": best(forward, len(q)), "jacobian": best(jacobian, len(q))}


def main() -> int:
    """Prints a line for each robot and function: the exit status."""
    slow = []
    for name in ("universal-ur5", "kuka-kr270"):
        robot = elastogeo.Robot(name)
        q = np.random.default_rng(1).uniform(-1, 1, (ROWS, len(robot.variables))) + [0, -1, 1, 0, 0.5, 0]
        works: dict[str, Callable[[Any], Any]] = {"forward": robot.forward, "jacobian": robot.jacobian}
        works["forward(weight=True)"] = lambda q: robot.forward(q, weight=True)
        if name == "kuka-kr270":
            works["compliance"] = robot.compliance
        other = theirs(robot, q)
        for label, work in works.items():

            def calls() -> None:
                for joints in q[:CALLS]:
                    work(joints)

            row, call = best(lambda: work(q), ROWS), best(calls, CALLS)
            line = f"python/{label}/{name} {row:.2f} us in an array, {call:.2f} us a call, {call - row:.2f} us of it the call's own"
            if label in other:
                line += f", {other[label]:.2f} us a call Pinocchio, ratio {other[label] / row:.1f} in an array, {other[label] / call:.1f} a call"
            print(line)
            if other and call - row > MOST * other["forward"]:
                slow.append(f"{label} of {name}")
    for each in slow:
        print(f"error: a call of {each} costs more than {MOST:.0f} calls of Pinocchio beyond the configuration", file=sys.stderr)
    return 1 if slow else 0


if __name__ == "__main__":
    sys.exit(main())

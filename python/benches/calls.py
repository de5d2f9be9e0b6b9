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
ROWS, CALLS = 5_000, 2_000
REPEATS = 30
#: A ratio, because machines differ: measured were 1.3 to 2.4.
MOST = 6.0

Works = dict[str, tuple[Callable[[], object], int]]


def best(works: Works) -> dict[str, float]:
    """Microseconds of one of what each work counts; in turns, so that all meet the same load of the machine."""
    found = dict.fromkeys(works, float("inf"))
    for _ in range(REPEATS):
        for name, (work, count) in works.items():
            started = time.perf_counter()
            work()
            found[name] = min(found[name], 1e6 * (time.perf_counter() - started) / count)
    return found


def one_by_one(work: Callable[[Any], object], q: Any) -> tuple[Callable[[], object], int]:
    """A call for each configuration."""

    def calls() -> None:
        for joints in q:
            work(joints)

    return calls, len(q)


def theirs(robot: elastogeo.Robot) -> dict[str, Callable[[Any], object]]:
    """Pinocchio's functions of the exported robot."""
    try:
        import pinocchio
    except ImportError:
        print("skipped: Pinocchio is not installed")
        return {}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "robot.urdf"
        robot.convert(file)
        model = pinocchio.buildModelFromUrdf(str(file))
    data, last, axes = model.createData(), model.nframes - 1, pinocchio.LOCAL_WORLD_ALIGNED
    return {
        "forward": lambda q: pinocchio.framesForwardKinematics(model, data, q),
        "jacobian": lambda q: pinocchio.computeFrameJacobian(model, data, q, last, axes),
    }


def main() -> int:
    """Prints a line for each robot and function: the exit status."""
    slow = []
    for name in ("universal-ur5", "kuka-kr270"):
        robot = elastogeo.Robot(name)
        q = np.random.default_rng(1).uniform(-1, 1, (ROWS, len(robot.variables))) + [0, -1, 1, 0, 0.5, 0]
        ours: dict[str, Callable[[Any], Any]] = {"forward": robot.forward, "jacobian": robot.jacobian}
        ours["forward(weight=True)"] = lambda q, of=robot: of.forward(q, weight=True)
        if name == "kuka-kr270":
            ours["compliance"] = robot.compliance
        other = theirs(robot)
        for label, work in ours.items():
            works: Works = {"row": (lambda work=work: work(q), ROWS), "call": one_by_one(work, q[:CALLS])}
            works |= {each: one_by_one(other[each], q[:CALLS]) for each in {"forward", label} & other.keys()}
            found = best(works)
            row, call = found["row"], found["call"]
            line = f"python/{label}/{name} {row:.2f} us in an array, {call:.2f} us a call, {call - row:.2f} us of it the call's own"
            if label in found:
                pin = found[label]
                line += f", {pin:.2f} us a call Pinocchio, ratio {pin / row:.1f} in an array, {pin / call:.1f} a call"
            print(line)
            if call - row > MOST * found.get("forward", float("inf")):
                slow.append(f"{label} of {name}")
    for each in slow:
        print(f"error: a call of {each} costs more than {MOST:.0f} calls of Pinocchio beyond the configuration", file=sys.stderr)
    return 1 if slow else 0


if __name__ == "__main__":
    sys.exit(main())

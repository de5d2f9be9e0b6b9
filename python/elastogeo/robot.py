"""A robot: its description, and its models over many configurations."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, Union

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import Array, rows
from ._run import Progress, flags, numbers, run
from .effects import Effect, instances
from .results import Result, Stiffness, data_frame

Joints = npt.ArrayLike | Mapping[str, float]
Format = Literal["yaml", "urdf", "mjcf", "ur-kinematics", "dh", "dh-modified", "mastering"]


class Robot:
    """A robot as its description says: a bundled name, or a ``.yaml`` or ``.urdf`` file.

    Joint values are SI (rad, m) in the order of :attr:`variables`, in arrays of shape (n, joints) or (joints,).

    >>> robot = Robot("universal-ur5")
    >>> robot.variables
    ['q1', 'q2', 'q3', 'q4', 'q5', 'q6']
    >>> robot.forward(np.zeros((2, 6))).shape
    (2, 4, 4)
    """

    def __init__(self, source: str | os.PathLike[str], *, effects: Sequence[Effect] = ()) -> None:
        self.source = os.fspath(source)
        self.effects = instances(effects)
        self._native = _native.Robot(self.source, self.effects)

    def __repr__(self) -> str:
        return f"Robot({self.source!r}): {len(self.variables)} variables, {len(self.markers)} markers"

    @property
    def name(self) -> str:
        """Its name in the description."""
        return self._native.name

    @property
    def variables(self) -> list[str]:
        """Names of the actuated variables, in the order of joint arrays."""
        return [name for name, _, _ in self._native.variables]

    @property
    def is_angle(self) -> list[bool]:
        """Whether each variable is an angle (rad) or a length (m)."""
        return [is_angle for _, is_angle, _ in self._native.variables]

    @property
    def limits(self) -> Array:
        """Least and greatest value of each variable, shape (joints, 2), rad and m; infinite where there are none."""
        free = (-np.inf, np.inf)
        return np.array([limits or free for _, _, limits in self._native.variables], dtype=np.float64).reshape(-1, 2)

    @property
    def frames(self) -> list[str]:
        """Names of the frames."""
        return self._native.frames

    @property
    def markers(self) -> list[str]:
        """Names of the markers."""
        return self._native.markers

    @property
    def parameters(self) -> Any:
        """All parameters as a pandas data frame: name, unit (SI), nominal, tolerance, free."""
        names = ("name", "unit", "nominal", "tolerance", "free")
        return data_frame([dict(zip(names, row)) for row in self._native.parameters])

    def forward(
        self,
        q: npt.ArrayLike,
        *,
        at: str | None = None,
        weight: bool = False,
        wrench: npt.ArrayLike | None = None,
    ) -> Array:
        """Poses of the tool centre point (or of a frame or marker ``at``) in the base frame.

        :param q: joints, shape (n, joints) or (joints,), rad and m
        :param weight: under own weight, preloads and the effects switched on; without it where the rigid robot is
        :param wrench: forces and torques on the tool, base axes, shape (6,) or (n, 6), N and N.m; own weight is added
        :return: homogeneous matrices, shape (n, 4, 4) or (4, 4), m

        >>> Robot("universal-ur5").forward([0, 0, 0, 0, 0, 0])[:3, 3].round(5).tolist()
        [-0.81725, -0.19145, -0.00549]
        """
        return self._native.forward(q, at, weight, wrench)

    def jacobian(self, q: npt.ArrayLike, *, at: str | None = None) -> Array:
        """Derivatives of the rigid position and rotation of the tool (or ``at``) by the variables, base axes.

        :param q: joints, shape (n, joints) or (joints,), rad and m
        :return: shape (n, 6, joints) or (6, joints): velocity (m), then angular velocity (rad)
        """
        return self._native.jacobian(q, at)

    def compliance(self, q: npt.ArrayLike, *, at: str | None = None) -> Array:
        """Compliance of the structure at the tool (or ``at``), base axes.

        :param q: joints, shape (n, joints) or (joints,), rad and m
        :return: shape (n, 6, 6) or (6, 6): displacement (m) and rotation (rad) by force (N) and moment (N.m)
        :raises Error: where the description declares nothing elastic
        """
        return self._native.compliance(q, at)

    def pose(
        self,
        q: Joints,
        *,
        wrench: npt.ArrayLike | None = None,
        weight: bool = False,
        progress: Progress | None = None,
        **options: object,
    ) -> Result:
        """Frames, markers and tool at one configuration, as the command ``pose`` has them (SI)."""
        given = flags(joints=self._joints(q), wrench=self._wrench(wrench), weight=weight, **options)
        return Result(*run(["pose", self.source, *given], progress=progress, effects=self.effects))

    def stiffness(
        self,
        q: Joints,
        *,
        wrench: npt.ArrayLike | None = None,
        at: str | None = None,
        weight: bool = False,
        progress: Progress | None = None,
        **options: object,
    ) -> Stiffness:
        """Stiffness at one configuration, deflection under a wrench (N, N.m, base axes), and the share of each element.

        :meth:`compliance` takes many configurations; where it is regular ``np.linalg.inv`` of it is the stiffness."""
        given = flags(joints=self._joints(q), wrench=self._wrench(wrench), at=at, weight=weight, **options)
        return Stiffness(*run(["stiffness", self.source, *given], progress=progress, effects=self.effects))

    def solve(
        self,
        target: npt.ArrayLike,
        *,
        start: Joints | None = None,
        weight: bool = False,
        restarts: int = 192,
        seed: int = 1,
        unreachable: Literal["raise", "nan"] = "raise",
    ) -> Array:
        """Joints that bring the tool to a target, or to each of many.

        :param target: homogeneous matrices (n, 4, 4) or (4, 4), or positions (n, 3) or (3,), m, base frame
        :param start: joints from which the nearest solution is sought, shape (joints,), or (n, joints) for many targets; without
            it all branches of a single target are found
        :param weight: bring the tool there as own weight, preloads and the effects switched on deflect it
        :param restarts: starts without a new branch after which the search ends; 0 tries ``start`` alone, which is faster
        :param seed: of the starts that are drawn
        :param unreachable: whether a target of many that is out of reach raises an error or gets joints that are NaN
        :return: the nearest solution of each target, shape (n, joints), rad and m; for a single target with ``start`` n is 1, and
            without it the number of solutions found, nearest to 0 first

        >>> robot = Robot("universal-ur5")
        >>> q = np.array([[0.3, -1.0, 1.2, 0.2, 0.5, 0.1], [0.4, -1.0, 1.2, 0.2, 0.5, 0.1]])
        >>> np.allclose(robot.solve(robot.forward(q), start=q[0]), q)
        True
        >>> len(robot.solve(robot.forward(q[0])))
        8
        """
        pose = np.asarray(target, dtype=np.float64)
        if pose.shape[-2:] == (4, 4) and pose.ndim in (2, 3):
            positions, turned = placed(pose, "target")
            is_single = pose.ndim == 2
        elif pose.shape[-1:] == (3,) and pose.ndim in (1, 2):
            positions, turned = pose.reshape(-1, 3), None
            is_single = pose.ndim == 1
        else:
            raise ValueError(f"target: an array of shape {pose.shape}; expected (n, 4, 4) or (4, 4), (n, 3) or (3,)")
        if not is_single:
            if start is None or isinstance(start, Mapping):
                raise ValueError("start: many targets need an array of shape (joints,), or one of (n, joints)")
            search = dict(weight=weight, restarts=restarts, seed=seed, leaves_gaps=unreachable == "nan")
            return self._native.solve(positions, turned, start, search)
        length, angle, _, _ = self._native.units
        given = np.concatenate([each[0] / size for each, size in ((positions, length), (turned, angle)) if each is not None])
        options = flags(**{"from": self._joints(start)}, weight=weight, restarts=restarts, seed=seed)
        found, _, _ = run(["solve", self.source, "--target=" + numbers(given), *options], effects=self.effects)
        solutions = [[each["joints"][name] for name in self.variables] for each in found["solutions"]]
        return np.array(solutions, dtype=np.float64).reshape(-1, len(self.variables))

    def convert(
        self,
        to: str | os.PathLike[str],
        *,
        format: Format | None = None,
        progress: Progress | None = None,
        **options: object,
    ) -> Result:
        """Writes the robot as a file for this or other programs.

        :param to: the file; without ``format`` its ending says which: ``.yaml`` a description, ``.urdf`` a URDF
        :param format: ``"yaml"``, ``"urdf"``, ``"mjcf"`` (the simulator MuJoCo) or ``"ur-kinematics"`` (the driver of Universal
            Robots), whatever the ending; needed for ``.xml``, which may be an MJCF or a URDF. ``"dh"``, ``"dh-modified"`` and
            ``"mastering"`` write tables (``.csv``, ``.xlsx``) of a controller's terms, beside those of ``nominal=``
        """
        given = flags(**({"as": format} if format else {}), **options)
        return Result(*run(["convert", self.source, os.fspath(to), *given], progress=progress, effects=self.effects))

    def check(self, *, progress: Progress | None = None, **options: object) -> Result:
        """What the description says: frames, loops, degrees of freedom, parameters, what is elastic."""
        return Result(*run(["check", self.source, *flags(**options)], progress=progress, effects=self.effects))

    def _joints(self, q: Joints | None) -> str | None:
        """Joints (SI) as the command line has them: in the description's units."""
        if q is None:
            return None
        length, angle, _, _ = self._native.units
        sizes = [angle if is_angle else length for is_angle in self.is_angle]
        if isinstance(q, Mapping):
            of = dict(zip(self.variables, sizes))
            return ",".join(f"{name}={float(value) / of.get(name, 1.0)!r}" for name, value in q.items())
        joints, is_single = rows(q, len(sizes), "q")
        if not is_single and len(joints) != 1:
            raise ValueError("one configuration at a time; `forward`, `jacobian` and `compliance` take many")
        return ",".join(
            f"{name}={float(value / size)!r}" for name, value, size in zip(self.variables, joints[0], sizes)
        )

    def _wrench(self, wrench: npt.ArrayLike | None) -> str | None:
        if wrench is None:
            return None
        given, is_single = rows(wrench, 6, "wrench")
        if not is_single and len(given) != 1:
            raise ValueError(f"wrench: an array of shape {given.shape}; expected one of shape (6,)")
        _, _, force, torque = self._native.units
        return numbers(given / np.array([force] * 3 + [torque] * 3))


#: A robot, or its name or file.
RobotLike = Union[Robot, str, "os.PathLike[str]"]

#: How far the columns of a rotation matrix may be from orthogonal and of length 1: hand-typed to some digits.
NO_ROTATION = 1e-4


def placed(poses: Array, what: str) -> tuple[Array, Array]:
    """Positions (n, 3) and rotation vectors (n, 3) of homogeneous matrices (n, 4, 4) or (4, 4).

    >>> placed(np.eye(4), "target")[0].tolist()
    [[0.0, 0.0, 0.0]]
    """
    matrices = poses.reshape(-1, 4, 4)
    turned = matrices[:, :3, :3]
    off = np.abs(turned @ turned.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2), initial=0.0)
    last = np.abs(matrices[:, 3] - [0.0, 0.0, 0.0, 1.0]).max(axis=1, initial=0.0)
    wrong = ~((off <= NO_ROTATION) & (last <= NO_ROTATION) & (np.linalg.det(turned) > 0))
    if wrong.any():
        row = f" of row {int(np.argmax(wrong))}" if poses.ndim == 3 else ""
        raise ValueError(f"{what}: the matrix{row} is no pose: a rotation, a position, and a last row 0 0 0 1")
    return matrices[:, :3, 3], rotation_vector(turned)


def rotation_vector(rotation: npt.ArrayLike) -> Array:
    """Rotation vectors (n, 3) or (3,), rad, of matrices (n, 3, 3) or (3, 3).

    >>> rotation_vector([[0, -1, 0], [1, 0, 0], [0, 0, 1]]).round(6).tolist()
    [0.0, 0.0, 1.570796]
    """
    given = np.asarray(rotation, dtype=np.float64)
    r = given.reshape(-1, 3, 3)
    # A quaternion by its greatest component, which never vanishes.
    x, y, z = r[:, 0], r[:, 1], r[:, 2]
    trace = r[:, 0, 0] + r[:, 1, 1] + r[:, 2, 2]
    four = np.stack(
        [
            np.stack([1 + trace, z[:, 1] - y[:, 2], x[:, 2] - z[:, 0], y[:, 0] - x[:, 1]], 1),
            np.stack([z[:, 1] - y[:, 2], 1 + 2 * x[:, 0] - trace, x[:, 1] + y[:, 0], x[:, 2] + z[:, 0]], 1),
            np.stack([x[:, 2] - z[:, 0], x[:, 1] + y[:, 0], 1 + 2 * y[:, 1] - trace, y[:, 2] + z[:, 1]], 1),
            np.stack([y[:, 0] - x[:, 1], x[:, 2] + z[:, 0], y[:, 2] + z[:, 1], 1 + 2 * z[:, 2] - trace], 1),
        ],
        1,
    )
    greatest = np.argmax(np.einsum("nii->ni", four), axis=1)
    quaternion = four[np.arange(len(r)), greatest]
    quaternion /= np.linalg.norm(quaternion, axis=1, keepdims=True)
    quaternion *= np.where(quaternion[:, :1] < 0, -1.0, 1.0)
    sine = np.linalg.norm(quaternion[:, 1:], axis=1)
    angle = 2 * np.arctan2(sine, quaternion[:, 0])
    size = np.where(sine > 1e-12, angle / np.where(sine > 0, sine, 1.0), 2.0)
    vectors: Array = (quaternion[:, 1:] * size[:, None]).reshape(given.shape[:-1])
    return vectors


def bundled_robots() -> list[str]:
    """Names of the robots that come with the package.

    >>> "kuka-kr270" in bundled_robots()
    True
    """
    return _native.bundled_robots()

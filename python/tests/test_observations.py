"""A kind of readings of a program's own, in Python."""

import math
from pathlib import Path
from typing import Any

import elastogeo
import numpy as np
import pytest
from elastogeo.observations import Observation, Point

#: Stations of a theodolite, m, measurement frame.
STATIONS = {"left": (2.0, -1.5, 0.4), "right": (1.8, 1.7, 0.9), "behind": (-2.2, 0.3, 1.4)}
#: One sigma of an angle, rad.
NOISE = 2e-5


class Bearing(Observation):
    """A theodolite at an anchor: azimuth and elevation of a marker."""

    name = "bearing"
    about = "Azimuth and elevation from an anchor."
    columns = {"azimuth": "rad", "elevation": "rad"}
    target = "anchor"

    def value(self, point: Point) -> list[float]:
        x, y, z = np.subtract(point.position, point.target[:3])
        return [math.atan2(y, x), math.atan2(z, math.hypot(x, y))]


class Faulty(Bearing):
    name = "faulty"

    def value(self, point: Point) -> list[float]:
        raise RuntimeError("no theodolite")


class Short(Bearing):
    name = "short"

    def value(self, point: Point) -> list[float]:
        return [0.0]


@pytest.fixture(scope="module")
def positions(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    """Exact positions of a robot with errors, by column."""
    folder = tmp_path_factory.mktemp("positions")
    elastogeo.simulate("universal-ur5", 60, folder, errors=0.5, noise=0, seed=3, unknown_base=True, unknown_tool=True)
    return elastogeo.Campaign(folder).to_dict()


def bearings(at: dict[str, list[Any]]) -> dict[str, list[Any]]:
    """The angles at which the stations see them, in plain numpy."""
    draw = np.random.default_rng(1)
    joints = [f"q{k}" for k in range(1, 7)]
    rows = []
    for k, pose in enumerate(at["pose"]):
        for station, place in STATIONS.items():
            x, y, z = np.array([at[axis][k] for axis in "xyz"]) - place
            angles = np.array([math.atan2(y, x), math.atan2(z, math.hypot(x, y))]) + NOISE * draw.standard_normal(2)
            rows.append([pose, station, *(at[joint][k] for joint in joints), *angles])
    return {name: list(column) for name, column in zip(["pose", "anchor", *joints, "azimuth", "elevation"], zip(*rows))}


def campaign(at: dict[str, list[Any]], kind: Observation, **more: Any) -> elastogeo.Campaign:
    anchors: dict[str, object] = {station: list(place) for station, place in STATIONS.items()}
    return elastogeo.Campaign.from_table(
        bearings(at), robot="universal-ur5", observes=kind.name, observations=[kind], estimate={"base": True, "tool": True},
        instrument={"orientation": NOISE}, anchors=anchors | more,
    )  # fmt: skip


def test_a_robot_is_calibrated_from_it(positions: dict[str, list[Any]]) -> None:
    found = elastogeo.identify(campaign(positions, Bearing()))
    own = campaign(positions, Bearing()).problem(found.kept, found, check=0)
    assert found.usable and np.std(own.residual(own.x0)) == pytest.approx(1, abs=0.15)
    # Its values predict the exact positions, which nothing has read.
    exact = elastogeo.Campaign.from_table(
        {name: column for name, column in positions.items() if name in ["pose", *(f"q{k}" for k in range(1, 7)), *"xyz"]},
        robot="universal-ur5", estimate={"base": True, "tool": True}, sigma=1e-5,
    )  # fmt: skip
    problem = exact.problem(found.kept, found, check=0)
    assert np.std(problem.residual(problem.x0)) * 1e-5 < 5e-5


def test_a_station_that_nobody_measured(positions: dict[str, list[Any]]) -> None:
    found = elastogeo.identify(campaign(positions, Bearing(), behind={"at": "unknown", "near": [-2, 0, 1]}))
    place = [1e-3 * found.values[f"behind.{axis}"] for axis in "xyz"]
    assert place == pytest.approx(STATIONS["behind"], abs=2e-4)


def test_two_of_one_name_know_nothing_of_each_other(positions: dict[str, list[Any]]) -> None:
    class Doubled(Bearing):
        def value(self, point: Point) -> list[float]:
            return [2 * angle for angle in super().value(point)]

    # One reading: the last point that one kind has seen is the first of the other.
    one = {name: column[:1] for name, column in bearings(positions).items()}
    slopes = []
    given: dict[str, Any] = {"robot": "universal-ur5", "observes": "bearing", "estimate": {"base": True}}
    given["anchors"] = {"left": list(STATIONS["left"])}
    both = [elastogeo.Campaign.from_table(one, observations=[kind], **given) for kind in (Bearing(), Doubled())]
    for own in both:
        problem = own.problem(["base.x"], check=0)
        slopes.append(problem.jacobian(problem.x0))
    assert slopes[1] == pytest.approx(2 * slopes[0], rel=1e-4, abs=1e-6 * np.abs(slopes[0]).max())


@pytest.mark.parametrize(("kind", "words"), [(Faulty(), "no theodolite"), (Short(), "2 finite numbers")])
def test_its_faults_are_raised(kind: Observation, words: str, positions: dict[str, list[Any]]) -> None:
    with pytest.raises(Exception, match=words):
        elastogeo.identify(campaign(positions, kind))
    # They are of that call alone.
    assert elastogeo.identify(campaign(positions, Bearing())).usable


def test_what_it_lacks_is_said(positions: dict[str, list[Any]]) -> None:
    class Nameless(Bearing):
        name = "Bearing 2"

    class Angles(Bearing):
        columns = {"azimuth": "rad", "range": "m"}

    class Known(Bearing):
        name = "position"

    for kind, words in [(Nameless(), "small letters"), (Angles(), "lengths first"), (Known(), "another name")]:
        with pytest.raises(ValueError, match=words):
            campaign(positions, kind)


@pytest.mark.parametrize(
    ("given", "words"),
    [([3], "here 3"), ([Bearing], r"the class Bearing: .*Bearing\(\)"), (Bearing(), "put it into a list"), ("bearing", "here 'bearing'")],
)  # fmt: skip
def test_what_is_no_kind(given: Any, words: str) -> None:
    with pytest.raises(TypeError, match=words):
        elastogeo.Campaign("kr270-simulated", observations=given)


def test_a_kind_that_was_not_given(positions: dict[str, list[Any]]) -> None:
    own = campaign(positions, Bearing())
    with pytest.raises(elastogeo.Error, match="unknown kind of readings `bearing`"):
        elastogeo.Campaign(own.source)


def test_it_is_simulated_and_planned(tmp_path: Path) -> None:
    class Height(Observation):
        name, columns = "height", {"height": "m"}

        def value(self, point: Point) -> list[float]:
            return [point.position[2]]

    made = elastogeo.simulate("universal-ur5", 5, tmp_path, observes="height", observations=[Height()])
    assert len(elastogeo.Campaign(made.folder, observations=[Height()])) == 5
    assert elastogeo.plan("universal-ur5", 20, observes="height", observations=[Height()]).joints.shape == (20, 6)
    with pytest.raises(elastogeo.Error, match="height"):
        elastogeo.simulate("universal-ur5", 5, tmp_path, observes="height")

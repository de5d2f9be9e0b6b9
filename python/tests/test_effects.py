"""An effect of a program's own, in Python."""

from pathlib import Path
from typing import Any

import elastogeo
import numpy as np
import pytest
from elastogeo.effects import Changes, Effect, Reading, Site, joint


class HosePull(Effect):
    """A hose package turns joint 5 as joints 4 and 6 wind it up."""

    name = "hose-pull"
    sites = ["joint:5"]
    parameters = {"pull": ("1/rad", 1e-4)}
    signature = "an angle of one joint that grows with the square of how far the hose is wound up"
    remedy = "lengthen the hose package"

    def changes(self, site: Site, reading: Reading) -> Changes:
        return {"pull": joint("q5", (reading.q[3] + reading.q[5]) ** 2)}


class Faulty(HosePull):
    def changes(self, site: Site, reading: Reading) -> Changes:
        raise RuntimeError("no law")


class Nowhere(HosePull):
    def changes(self, site: Site, reading: Reading) -> Changes:
        return {"pull": joint("q9", 1.0)}


class Nan(HosePull):
    def changes(self, site: Site, reading: Reading) -> Changes:
        return {"pull": joint("q5", float("nan"))}


class Nothing(HosePull):
    def changes(self, site: Site, reading: Reading) -> Changes:
        return None  # type: ignore[return-value]


class Number(HosePull):
    def changes(self, site: Site, reading: Reading) -> Changes:
        return {"pull": 3}  # type: ignore[dict-item]


class Elsewhere(HosePull):
    sites = ["joint:5", "joint:99"]


class Taken(HosePull):
    name = "backlash"


PULL = 3e-4


@pytest.fixture(scope="module")
def pulled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of a robot whose hose pulls."""
    folder = tmp_path_factory.mktemp("pulled")
    elastogeo.simulate(
        "universal-ur5", 60, folder, effects=[HosePull()], seed=5, errors=0.5, noise=0.03,
        unknown_base=True, unknown_tool=True, effect=f"hose-pull@joint:5:pull={PULL}",
    )  # fmt: skip
    return folder


def test_it_is_found_and_explains_the_gap(pulled: Path) -> None:
    campaign = elastogeo.Campaign(pulled, effects=[HosePull()])
    found = elastogeo.diagnose(campaign)
    causes = [(each["effect"], each["site"]) for each in found["causes"]]
    assert ("hose-pull", "joint:5") in causes
    (own,) = (each for each in found["causes"] if each["effect"] == "hose-pull")
    assert own["parameters"][0]["value"] == pytest.approx(PULL, rel=0.1)
    without = elastogeo.diagnose(pulled)
    assert "hose-pull" not in [each["effect"] for each in without["causes"]]


@pytest.mark.parametrize(
    ("effect", "words"),
    [
        (Faulty(), "no law"),
        (Nowhere(), "q9"),
        (Nan(), "`pull: joint q5` is not finite"),
        (Nothing(), "`changes` returns .* here None"),
        (Number(), "`changes` returns .*'pull': 3"),
        (Elsewhere(), "`joint:99`"),
        (Taken(), "`backlash` is an effect of elastogeo itself"),
    ],
)
def test_its_faults_are_raised(effect: Effect, words: str, pulled: Path) -> None:
    with pytest.raises(Exception, match=words):
        elastogeo.diagnose(pulled, effects=[effect])


def test_a_description_that_has_it(pulled: Path, tmp_path: Path) -> None:
    file = tmp_path / "diagnosed.yaml"
    elastogeo.diagnose(pulled, effects=[HosePull()], apply=file)
    q = np.array([0.1, -1.0, 1.0, 0.8, 0.5, 0.7])
    robot = elastogeo.Robot(file, effects=[HosePull()])
    assert np.linalg.norm((robot.forward(q, weight=True) - robot.forward(q))[:3, 3]) > 1e-5
    with pytest.raises(RuntimeError, match="no law"):
        elastogeo.Robot(file, effects=[Faulty()]).forward(q, weight=True)
    with pytest.raises(elastogeo.Error, match="hose-pull"):
        elastogeo.Robot(file)


def test_what_it_lacks_is_said() -> None:
    with pytest.raises(ValueError, match="name"):
        elastogeo.Robot("universal-ur5", effects=[Effect()])

    class Sizeless(HosePull):
        parameters = {"pull": ("1/rad", float("nan"))}

    with pytest.raises(ValueError, match="above 0"):
        elastogeo.Robot("universal-ur5", effects=[Sizeless()])

    for own, words in ((Elsewhere(), "`joint:99`"), (Taken(), "`backlash` is an effect of elastogeo itself")):
        with pytest.raises(elastogeo.Error, match=words):
            elastogeo.Robot("universal-ur5", effects=[own])
        with pytest.raises(elastogeo.Error, match=words):
            elastogeo.Campaign("kr270-simulated", effects=[own])

    class Misplaced(HosePull):
        sits_at = "elbow"

    with pytest.raises(elastogeo.Error, match="elbow"):
        elastogeo.Robot("universal-ur5", effects=[Misplaced()])


@pytest.mark.parametrize(
    ("effects", "words"),
    [([HosePull], r"the class HosePull: .*HosePull\(\)"), ([3], "here 3"), (HosePull(), "put it into a list"), ("hose-pull", "list of")],
)
def test_what_is_no_effect(effects: Any, words: str) -> None:
    for call in (
        lambda: elastogeo.diagnose("kr270-simulated", effects=effects),
        lambda: elastogeo.Robot("universal-ur5", effects=effects),
        lambda: elastogeo.Campaign("kr270-simulated", effects=effects),
    ):
        with pytest.raises(TypeError, match=words):
            call()


def test_a_campaign_has_the_effects_of_its_robot() -> None:
    robot, own = elastogeo.Robot("kuka-kr270", effects=[HosePull()]), HosePull()
    assert elastogeo.Campaign("kr270-simulated", robot=robot).effects == robot.effects
    assert elastogeo.Campaign("kr270-simulated", robot=robot, effects=[own]).effects == [own]


def test_point_is_in_order() -> None:
    assert elastogeo.effects.point(np.ones(3)) == ("point", "", [1.0, 1.0, 1.0, 0.0, 0.0, 0.0])

"""Every command that computes something is a function: results are the command's, with progress and effects."""

import inspect
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

import elastogeo
import numpy as np
import pytest
from conftest import Command
from elastogeo.effects import Changes, Effect, Reading, Site, joint
from test_parity import timeless

FUNCTIONS = [
    "compensate", "compensator", "diagnose", "identifiability", "identify", "place", "plan", "register", "report", "residuals",
    "sensitivity", "simulate", "stiffness", "track", "view",
]  # fmt: skip
#: An arm that has a compensator, and one of its configurations.
ROBOT, Q = "kuka-kr270", [0, -1.0, 1.5, 0, 0.3, 0]
#: Compliances of the joint by angle, deg and 1e-6 rad/(N.m).
BY_ANGLE: dict[str, list[float]] = {"q": [-130, -110, -90, -70, -50], "k2": [0.287, 0.293, 0.296, 0.297, 0.295]}


class Pull(Effect):
    """Something that no description has."""

    name = "pull-of-a-test"
    sites = ["joint:5"]
    parameters = {"pull": ("1/rad", 1e-4)}

    def changes(self, site: Site, reading: Reading) -> Changes:
        return {"pull": joint("q5", reading.q[3] ** 2)}


@pytest.fixture(scope="module")
def months(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Campaigns of one robot, a length of which is another in the last."""
    folder = tmp_path_factory.mktemp("months")
    for name, seed, more in [("january", 1, {}), ("february", 2, {}), ("march", 3, {"set": "3.d=1"})]:
        elastogeo.simulate("universal-ur5", 40, folder / name, seed=seed, noise=0.05, errors=0, **more)  # type: ignore[arg-type]
    return [folder / name for name in ("january", "february", "march")]


def calls(months: list[Path], into: Path) -> dict[str, Callable[..., Any]]:
    """A call of each function, which takes further keywords."""
    robot, campaign = ROBOT, "kr270-simulated"
    path = elastogeo.Robot(robot).forward([Q])
    return {
        "compensate": lambda **more: elastogeo.compensate(robot, path, start=Q, **more),
        "compensator": lambda **more: elastogeo.compensator(mounting=[184.72, 685.93, 123.3], compliances=BY_ANGLE, **more),
        "diagnose": lambda **more: elastogeo.diagnose(campaign, **more),
        "identifiability": lambda **more: elastogeo.identifiability(robot, campaign, **more),
        "identify": lambda **more: elastogeo.identify(campaign, **more),
        "place": lambda **more: elastogeo.place(robot, path, wrench=[0, 0, -1000, 0, 0, 0], start=Q, move={"x": (0, 0.01)}, **more),
        "plan": lambda **more: elastogeo.plan(robot, 8, **more),
        "register": lambda **more: elastogeo.register(campaign, **more),
        "report": lambda **more: elastogeo.report(campaign, **more),
        "residuals": lambda **more: elastogeo.residuals(robot, campaign, **more),
        "sensitivity": lambda **more: elastogeo.sensitivity(robot, campaign, **more),
        "simulate": lambda **more: elastogeo.simulate(robot, 8, into, **more),
        "stiffness": lambda **more: elastogeo.stiffness(robot, Q, **more),
        "track": lambda **more: elastogeo.track("universal-ur5", months[:2], **more),
        "view": lambda **more: elastogeo.view(robot, **more),
    }


def test_all_of_them() -> None:
    here = [name for name in elastogeo.__all__ if getattr(getattr(elastogeo, name), "__module__", "") == "elastogeo.commands"]
    assert sorted(here) == FUNCTIONS


@pytest.mark.parametrize("name", FUNCTIONS)
def test_progress_and_effects(name: str, months: list[Path], tmp_path: Path) -> None:
    assert {"progress", "effects"} <= set(inspect.signature(getattr(elastogeo, name)).parameters)
    told: list[str] = []
    found = calls(months, tmp_path / "made")[name](progress=told.append, effects=[Pull()])
    assert all(isinstance(each, str) for each in told) and "<" in found._repr_html_()
    with pytest.raises(TypeError, match="the class Pull"):
        calls(months, tmp_path / "again")[name](effects=[Pull])


def test_sensitivity(command: Command) -> None:
    found = elastogeo.sensitivity(ROBOT, "kr270-simulated")
    assert found.to_dict() == command("sensitivity", ROBOT, "kr270-simulated")
    assert {"name", "position_mean", "rotation_max"} <= set(found.parameters.columns)
    assert {"unit", "value", "position_max_of_value"} <= set(found.elastic.columns) and "<table" in found._repr_html_()


def test_identifiability_in_a_notebook() -> None:
    found = elastogeo.identifiability("kuka-ir663", "ir663-paper-poses")
    assert (found.rank, len(found.kept)) == (found["rank"], found["kept"])
    assert found.condition == pytest.approx(found.singular_values.max() / found.singular_values.min())
    into = found.dropped.set_index("name")["into"]
    assert into["2.r"] == {"3.r": pytest.approx(1)}
    shown = found._repr_html_()
    assert shown.count("<table") == 2 and "<svg" in shown and "screw8.stroke" in shown


def test_plan_in_a_notebook() -> None:
    found = elastogeo.plan(ROBOT, 8)
    assert found.error == found["error"]["planned"] and len(found.bought) == len(found["bought"])
    assert found.parameters["ci95"].notna().all()
    assert found._repr_html_().count("<table") == 2 and "<svg" in found._repr_html_()


def test_compensator(tmp_path: Path, command: Command) -> None:
    rows = "\n".join(f"{q},{k2}" for q, k2 in zip(BY_ANGLE["q"], BY_ANGLE["k2"]))
    (tmp_path / "k2.csv").write_text(f"q,k2\n{rows}\n")
    wanted = command("compensator", "--mounting=184.72,685.93,123.3", f"--compliances={tmp_path / 'k2.csv'}")
    for compliances in (BY_ANGLE, tmp_path / "k2.csv"):
        found = elastogeo.compensator(mounting=[184.72, 685.93, 123.3], compliances=compliances)
        assert found.to_dict() == wanted
    assert found.parameters.set_index("name").loc["kc", "value"] == wanted["kc"]["value"]
    assert found.compliances["q"].tolist() == BY_ANGLE["q"] and "<table" in found._repr_html_()
    with pytest.raises(elastogeo.Error, match="no measurements of the compensator"):
        elastogeo.compensator()


def test_compensator_of_a_campaign(tmp_path: Path) -> None:
    loads = [[0, 0, -2500, 0, 0, 0], [1500, 0, -1000, 0, 0, 0]]
    elastogeo.simulate(ROBOT, 24, tmp_path / "loaded", wrench=loads, observes="deflection", seed=3)
    found = elastogeo.compensator(deflections=tmp_path / "loaded")
    value = found.parameters.set_index("name").loc["s0"]
    assert abs(value["value"] - 458) < 2 * value["ci95"]


def test_place(command: Command) -> None:
    wanted = command("place", "kuka-ir663", "ir663-strip", "--process=ir663-strip", "--move=x=-50:50")
    found = elastogeo.place("kuka-ir663", "ir663-strip", process="ir663-strip", move={"x": (-0.05, 0.05)})
    assert found.to_dict() == wanted and found.motion.tolist() == wanted["moved"]["motion"]
    assert found.joints.shape == (26, 6) and found.deflections["stage"].tolist() == ["given", "posture", "best"]
    assert found.deflections["rms"].iloc[2] < found.deflections["rms"].iloc[0] and "<svg" in found._repr_html_()
    with pytest.raises(TypeError, match="`move` maps"):
        elastogeo.place("kuka-ir663", "ir663-strip", move="x=-50:50")  # type: ignore[arg-type]


def test_place_of_arrays() -> None:
    robot = elastogeo.Robot(ROBOT)
    poses = robot.forward([Q, [0.05, *Q[1:]]])
    load = [0, 0, -1000, 0, 0, 0]
    found = elastogeo.place(robot, poses, wrench=load, start=Q, move={"x": (-0.1, 0.1), "rz": (-0.1, 0.1)})
    moved = np.linalg.norm(robot.forward(found.joints)[1, :3, 3] - robot.forward(found.joints)[0, :3, 3])
    assert moved == pytest.approx(np.linalg.norm(poses[1, :3, 3] - poses[0, :3, 3]), abs=1e-6)
    assert found["best"]["rms"] < found["given"]["rms"] and np.abs(found.motion).max() <= 0.5
    each = elastogeo.place(robot, poses, wrench=[load, load], start=Q, move={"x": (-0.1, 0.1)})
    assert each["given"] == pytest.approx(found["given"])


def test_track(months: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: Command) -> None:
    monkeypatch.chdir(tmp_path)
    names = [str(month) for month in months]
    wanted = command("track", "universal-ur5", *names, "--change=3.d=0.1")
    page = tmp_path / "track.html"
    found = elastogeo.track("universal-ur5", [elastogeo.Campaign(names[0]), *months[1:]], page, change={"3.d": 0.1})
    assert timeless(found.to_dict()) == timeless(wanted)
    assert found.html == page.read_text() and "srcdoc" in found._repr_html_()
    assert found.changed and found.usable and "frame 3" in found.answer
    assert found.checks["alarm"].tolist() == [False, False, True]
    last = found.parameters.query("name == '3.d'").iloc[-1]
    assert last["difference"] == pytest.approx(1, abs=2 * last["ci95"]) and last["unit"] == "mm"
    assert found.next["name"].tolist() == ["3.d"] and found.next["poses"][0] > 0


def test_track_as_a_nightly_job(months: list[Path]) -> None:
    days: list[str | date] = [date(2026, 1, 12), "2026-02-09", date(2026, 3, 9)]
    found = elastogeo.track("universal-ur5", months, dates=days, alarm="last", a_year=6)
    assert not found.usable and found.checks["date"].tolist() == ["2026-01-12", "2026-02-09", "2026-03-09"]
    # A page that went with a temporary folder is not named.
    assert "track.html" not in found.text and "page.html" not in found.text and "<html" in found.html
    with pytest.raises(TypeError, match="a list in the order of time"):
        elastogeo.track("universal-ur5", str(months[0]))


def test_view(tmp_path: Path) -> None:
    page, drawing = tmp_path / "view.html", tmp_path / "robot.svg"
    found = elastogeo.view(ROBOT, page, q=Q, wrench=[0, 0, -2500, 0, 0, 0], svg=drawing)
    assert found.html == page.read_text() and "<svg" in drawing.read_text() and "srcdoc" in found._repr_html_()
    assert list(found["joints"].values()) == pytest.approx(Q)


def test_certificate() -> None:
    found = elastogeo.report("kr270-simulated", certificate=True, tolerance=0.8)
    assert (found["verdict"], found["tolerance"]) == ("pass", 0.8) and "certificate: " not in found.text


def test_the_robot_that_a_campaign_was_given(tmp_path: Path) -> None:
    """What `Campaign(.., robot=..)` says holds for commands too."""
    file = tmp_path / "mine.yaml"
    calibrated = elastogeo.identify("kr270-simulated", save=file)
    found = elastogeo.register(elastogeo.Campaign("kr270-simulated", robot=file))
    assert timeless(found.to_dict()) == timeless(elastogeo.register("kr270-simulated", robot=file).to_dict())
    assert found.rms["after"] == pytest.approx(calibrated.rms["after"], abs=0.1)


def test_check_of_a_campaign(command: Command) -> None:
    assert elastogeo.Campaign("kr270-simulated").check().to_dict() == command("check", "kr270-simulated")

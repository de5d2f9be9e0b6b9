"""Many campaigns on a scheduler with workers: nothing lost, nothing twice, the bits of the sequential run."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import elastogeo
import pytest
from elastogeo import _native
from test_parity import timeless

distributed = pytest.importorskip(
    "distributed", reason="fleets need `pip install '.[fleet]'`: dask is not installed"
)
parquet = pytest.importorskip(
    "pyarrow.parquet", reason="fleets need `pip install '.[fleet]'`: pyarrow is not installed"
)

from elastogeo.fleet import engine  # noqa: E402
from elastogeo.fleet.__main__ import main  # noqa: E402
from elastogeo.fleet.jobs import Job, jobs  # noqa: E402
from elastogeo.fleet.work import execute  # noqa: E402

COUNT = 14
pytestmark = pytest.mark.filterwarnings("ignore")
Start = Callable[..., "subprocess.Popen[str]"]


def make(folder: Path, seed: int) -> None:
    elastogeo.simulate("universal-ur5", 12, folder, noise=0.05, seed=seed, unknown_base=True)


def bad(folder: Path) -> None:
    folder.mkdir(parents=True)
    (folder / "campaign.yaml").write_text("campaign: bad\nrobot: universal-ur5\nmeasurements: m.csv\n")
    (folder / "m.csv").write_text("pose,q1,q2,q3,q4,q5,q6,x,y\na,0,0,0,0,0,0,one,2\n")


def rows(folder: Path) -> list[dict[str, Any]]:
    found = [row for file in sorted(folder.glob("part-*.parquet")) for row in parquet.read_table(file).to_pylist()]
    assert not list(folder.glob(".*.tmp"))
    return found


def compared(found: list[dict[str, Any]]) -> list[Any]:
    """All but the seconds."""
    return [timeless(row | {"json": json.loads(row["json"])}) for row in found]


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Campaigns of some robots, one of them bad."""
    folder = tmp_path_factory.mktemp("fleet") / "robots"
    for seed in range(COUNT):
        make(folder / f"robot-{seed:02}" / "2026-01", seed + 1)
    bad(folder / "robot-bad")
    return folder


@pytest.fixture(scope="module")
def one_after_another(fleet: Path) -> Path:
    into = fleet.parent / "sequential"
    assert main(["diagnose", str(fleet), "--into", str(into), "--sequential"]) == 1
    return into


@pytest.fixture
def start() -> Iterator[Start]:
    """Starts programs of Python; they end with the test."""
    begun: list[subprocess.Popen[str]] = []

    def of(*arguments: str) -> "subprocess.Popen[str]":
        whole, pipe = [sys.executable, "-m", *arguments], subprocess.PIPE
        begun.append(subprocess.Popen(whole, text=True, start_new_session=True, stdout=pipe, stderr=pipe))
        return begun[-1]

    yield of
    for program in begun:
        program.kill()
        program.communicate()


def until(held: Callable[[], Any], program: "subprocess.Popen[str]", seconds: float = 120) -> Any:
    """Waits until something holds, while a program runs."""
    end = time.monotonic() + seconds
    while not (found := held()):
        assert time.monotonic() < end and program.poll() is None, program.communicate()
        time.sleep(0.01)
    return found


def test_sequentially(fleet: Path, one_after_another: Path) -> None:
    found = rows(one_after_another)
    assert len(found) == COUNT + 1 and len({row["path"] for row in found}) == COUNT + 1
    for row in [row for row in found if row["status"] == "done"][:3]:
        alone = elastogeo.diagnose(row["path"])
        assert timeless(json.loads(row["json"])) == timeless(alone.to_dict())
        assert (row["verdict"], row["before"]) == (alone.verdict, alone["gap"]["rms"])
        assert [cause["effect"] for cause in row["causes"]] == [cause["effect"] for cause in alone["causes"]]
    # One bad campaign does not stop the rest.
    assert {row["status"] for row in found if row["path"] != str(fleet / "robot-bad")} == {"done"}
    (row,) = [row for row in found if row["path"] == str(fleet / "robot-bad")]
    assert (row["status"], row["exit_status"], row["verdict"]) == ("error", 2, None)
    assert row["error"].startswith("the column `z` is missing; column `x`") and row["diagnostics"][-1]["file"].endswith(
        "m.csv"
    )


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_a_worker_killed_in_the_middle(fleet: Path, one_after_another: Path, tmp_path: Path, start: Start) -> None:
    where, into = tmp_path / "scheduler.json", tmp_path / "results"
    quiet = ("--scheduler-file", str(where), "--no-dashboard")
    scheduler = start("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", *quiet)
    for _ in range(2):
        start("distributed.cli.dask_worker", "--host", "127.0.0.1", "--no-nanny", "--nthreads", "1", *quiet)
    until(where.is_file, scheduler)
    with distributed.Client(scheduler_file=str(where), timeout=20) as client:
        client.wait_for_workers(2, timeout=30)
        run = start("elastogeo.fleet", "diagnose", str(fleet), "--into", str(into), "--scheduler", str(where))
        until(lambda: list(into.glob("part-*.parquet")), run)
        address, number = sorted(client.run(os.getpid).items())[0]
        until(lambda: client.processing()[address], run)
        os.kill(number, signal.SIGKILL)
        out, err = run.communicate(timeout=200)
        assert list(client.ncores()) != [] and address not in client.ncores()
    assert (run.returncode, f"{COUNT + 1} run in" in out) == (1, True), out + err
    assert "\r" not in err  # no bar in a pipe
    assert compared(rows(into)) == compared(rows(one_after_another))


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_an_interrupted_run_goes_on(fleet: Path, one_after_another: Path, tmp_path: Path, start: Start) -> None:
    into = tmp_path / "results"
    asked = ("diagnose", str(fleet), "--into", str(into), "--workers", "2")
    run = start("elastogeo.fleet", *asked)
    until(lambda: list(into.glob("part-*.parquet")), run)
    os.killpg(run.pid, signal.SIGINT)  # as Ctrl-C in a terminal: the workers hear it too
    out, err = run.communicate(timeout=100)
    assert run.returncode == 130 and "what was done is kept" in err, out + err
    before = {row["path"]: row["seconds"] for row in rows(into)}
    assert 0 < len(before) < COUNT
    run = start("elastogeo.fleet", *asked)
    out, err = run.communicate(timeout=200)
    assert run.returncode == 1 and f"{len(before)} there before" in out, out + err
    found = rows(into)
    assert compared(found) == compared(rows(one_after_another))
    # What was there is as it was, to the time that it took.
    assert {row["path"]: row["seconds"] for row in found if row["path"] in before} == before


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_an_interruption_that_a_destructor_swallows_is_heeded(
    fleet: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Last:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGINT)

    def interrupted(job: Job) -> dict[str, Any]:
        last = Last()
        del last
        return execute(job)

    monkeypatch.setattr(engine, "execute", interrupted)
    assert main(["diagnose", str(fleet), "--into", str(tmp_path / "results"), "--sequential"]) == 130
    assert "what was done is kept" in capsys.readouterr().err
    assert len(rows(tmp_path / "results")) == 1
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_only_what_changed_is_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for seed in range(3):
        make(tmp_path / f"robots/{seed}", seed + 1)
    into = tmp_path / "results"
    ran: list[str] = []

    def watched(job: Job) -> dict[str, Any]:
        ran.append(Path(job.path).name)
        return execute(job)

    monkeypatch.setattr(engine, "execute", watched)

    def again(*options: str) -> list[str]:
        ran.clear()
        main(["identify", str(tmp_path / "robots/*"), "--into", str(into), "--sequential", *options])
        return sorted(ran)

    assert again() == ["0", "1", "2"] and again() == []
    (tmp_path / "robots/1/campaign.yaml").touch()
    assert again() == []
    with (tmp_path / "robots/1/measurements.csv").open("a") as file:
        file.write("\n")
    make(tmp_path / "robots/3", 4)
    assert again() == ["1", "3"] and len(rows(into)) == 4
    assert again("--", "--loss", "huber") == ["0", "1", "2", "3"] and again("--", "--loss", "huber") == []
    assert [row["settings"] for row in rows(into)].count("--loss huber") == 4 and len(rows(into)) == 8


def test_lost_tasks_are_tried_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make(tmp_path / "robots/0", 1)
    asked = ["identify", str(tmp_path / "robots"), "--into", str(tmp_path / "results"), "--sequential"]

    def full(_: object) -> None:
        raise OSError("the disk is full")

    with monkeypatch.context() as patched:
        patched.setattr(engine, "execute", full)
        assert main(asked) == 1
    (row,) = rows(tmp_path / "results")
    assert (row["status"], row["error"]) == ("lost", "OSError: the disk is full")
    assert main(asked) == 0
    (row,) = rows(tmp_path / "results")
    assert (row["status"], row["error"], row["exit_status"]) == ("done", None, 0)


def test_sealed_campaigns(tmp_path: Path, command: Callable[..., dict[str, Any]]) -> None:
    command("blind", "make", "--count", "2", "--into", str(tmp_path / "sealed"))
    assert main(["blind", str(tmp_path / "sealed"), "--into", str(tmp_path / "results"), "--sequential"]) == 0
    wanted = {
        each["said"]["truth"]["name"]: each for each in command("blind", "score", str(tmp_path / "sealed"))["campaigns"]
    }
    for row in rows(tmp_path / "results"):
        (found,) = json.loads(row["json"])["campaigns"]
        assert timeless(found) == timeless(wanted[Path(row["path"]).name])
        assert row["verdict"] == ("right" if found["right"] else "wrong") and row["causes"]
    # What a cause consists of need not be numbers: by what a joint with play changes its flank.
    play = "backlash@joint:2:half_width=1e-3,by=approach"
    elastogeo.simulate("universal-ur5", 30, tmp_path / "played", noise=0.05, effect=play, unknown_base=True)
    asked = ["diagnose", str(tmp_path / "played"), "--into", str(tmp_path / "diagnosed"), "--sequential"]
    assert main(asked) == 0
    (row,) = rows(tmp_path / "diagnosed")
    values = [each["value"] for cause in json.loads(row["json"])["causes"] for each in cause["parameters"]]
    held = [each["word"] if each["value"] is None else each["value"] for each in row["parameters"]]
    assert held == values and any(isinstance(value, str) for value in values)


def test_a_robot_over_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of `track` a row for each robot: the command is called with its description and its campaigns in order."""
    for arm in "ab":
        for month in (2, 1):
            make(tmp_path / arm / f"2026-0{month}", month)
    (tmp_path / "b/own.yaml").write_text("name: own")
    for campaign in (tmp_path / "b").glob("*/campaign.yaml"):
        campaign.write_text(campaign.read_text().replace("robot: universal-ur5", "robot: ../own.yaml"))
    called: list[list[str]] = []

    def tracked(arguments: list[str], *_: object) -> tuple[str, str, bool]:
        called.append(arguments)
        return json.dumps({"checks": [{"alarm": False}, {"alarm": "/a/" in arguments[2]}]}), "", False

    monkeypatch.setattr(_native, "command", tracked)
    asked = ["track", str(tmp_path), "--into", str(tmp_path / "results"), "--sequential", "--", "--a-year", "4"]
    assert main(asked) == 0
    whole = [["track", robot, *(str(tmp_path / arm / f"2026-0{month}") for month in (1, 2)), "--a-year", "4"]
             for arm, robot in (("a", "universal-ur5"), ("b", str(tmp_path / "b/own.yaml")))]  # fmt: skip
    assert sorted(call[:-1] for call in called[1:]) == sorted(whole)
    verdicts = {row["path"]: row["verdict"] for row in rows(tmp_path / "results")}
    assert verdicts == {str(tmp_path / "a"): "changed", str(tmp_path / "b"): "unchanged"}


@pytest.mark.parametrize("option", [[], ["--", "--dates=2026-01-05,2026-02-05,2026-03-05"]])
def test_an_unreadable_month(option: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The other months of the robot are tracked, and what is wrong with that one is said."""
    arm = tmp_path / "robots/a"
    bad(arm / "2026-01")
    for month in (2, 3):
        elastogeo.simulate("universal-ur5", 30, arm / f"2026-0{month}", noise=0.05, seed=month, unknown_base=True)
    asked = ["track", str(tmp_path / "robots"), "--into", str(tmp_path / "results"), "--sequential", *option]
    assert main(asked) == 1
    (row,) = rows(tmp_path / "results")
    assert (row["status"], row["verdict"], row["exit_status"]) == ("incomplete", "changed", 0)
    assert row["error"].startswith("2026-01 left out: the column `z` is missing")
    assert row["diagnostics"][0]["message"].startswith("2026-01: ") and row["diagnostics"][0]["file"].endswith("m.csv")
    found = json.loads(row["json"])
    dates = ["--dates=2026-02-05,2026-03-05"] if option else []
    others = ["track", "universal-ur5", str(arm / "2026-02"), str(arm / "2026-03"), *dates, "--format=json"]
    wanted = json.loads(_native.command(others)[0])
    assert len(found["checks"]) == 2 and timeless(found["checks"]) == timeless(wanted["checks"])
    # It is not run again until a file changes.
    ran: list[str] = []

    def watched(job: Job) -> dict[str, Any]:
        ran.append(job.path)
        return execute(job)

    monkeypatch.setattr(engine, "execute", watched)
    assert main(asked) == 1 and ran == []
    shutil.rmtree(arm / "2026-01")
    elastogeo.simulate("universal-ur5", 30, arm / "2026-01", noise=0.05, seed=9, unknown_base=True)
    assert main(asked) == 0 and ran == [str(arm)]
    (row,) = rows(tmp_path / "results")
    assert (row["status"], row["error"], len(json.loads(row["json"])["checks"])) == ("done", None, 3)


def test_a_robot_whose_months_are_all_unreadable(tmp_path: Path) -> None:
    for month in (1, 2):
        bad(tmp_path / f"robots/a/2026-0{month}")
    assert main(["track", str(tmp_path / "robots"), "--into", str(tmp_path / "results"), "--sequential"]) == 1
    (row,) = rows(tmp_path / "results")
    assert (row["status"], row["exit_status"]) == ("error", 2) and "`z` is missing" in row["error"]


def test_campaigns_of_a_list(tmp_path: Path) -> None:
    make(tmp_path / "a", 1)
    (tmp_path / "list.txt").write_text(f"# of January\n{tmp_path}/a\n\n{tmp_path}/gone\nkr270-simulated\n")
    found = jobs("identify", [str(tmp_path / "list.txt"), str(tmp_path / "a" / "campaign.yaml")], [])
    assert [job.path for job in found] == [str(tmp_path / name) for name in ("a", "a/campaign.yaml", "gone")] + [
        "kr270-simulated"
    ]
    assert main(["identify", str(tmp_path / "list.txt"), "--into", str(tmp_path / "results"), "--sequential"]) == 1
    assert sorted(row["status"] for row in rows(tmp_path / "results")) == ["done", "done", "error"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["identify", "nowhere", "--into", "results"], "no campaign at `nowhere`"),
        (["identify", "empty", "--into", "results"], "no campaign at `empty`"),
        (["identify", "empty.txt", "--into", "results"], "the list is empty"),
        (["identify", "kr270-simulated", "--into", "a-file"], "cannot be written into `a-file`"),
        (["identify", "kr270-simulated", "--into", "foreign"], "holds no results of a fleet"),
        (
            ["identify", "kr270-simulated", "--into", "results", "--scheduler", "tcp://127.0.0.1:1"],
            "no scheduler answers",
        ),
        (["identify", "kr270-simulated", "--into", "results", "--scheduler", "none.json"], "there is no such file"),
        (["identify", "kr270-simulated", "--into", "results", "--", "--losss=huber"], "--losss"),
        (["identify", "kr270-simulated", "--into", "results", "--", "--robot", "no-arm"], "no-arm"),
        (["identify", "kr270-simulated", "--into", "results", "--", "--save=x.yaml"], "one file for all campaigns"),
    ],
)
def test_wrong_inputs(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(engine, "TIMEOUT", 1.0)
    (tmp_path / "empty").mkdir()
    (tmp_path / "foreign").mkdir()
    for name in ("empty.txt", "a-file", "foreign/part-00.parquet"):
        (tmp_path / name).write_text("")
    assert main(arguments) == 2
    told = capsys.readouterr()
    assert message in told.err and told.err.startswith("error: ") and told.out == ""


def test_one_run_at_a_time(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("fcntl", reason="files cannot be locked")
    from elastogeo.fleet.dataset import Dataset

    held = Dataset(str(tmp_path))
    assert main(["identify", "kr270-simulated", "--into", str(tmp_path), "--sequential"]) == 2
    assert "another run writes there" in capsys.readouterr().err
    held.close()


@pytest.mark.parametrize(
    ("options", "words"),
    [(["--hold=zz"], "unknown parameter `zz`"), (["--against=zz"], "there is no bundled robot `zz`"), (["--robot=zz"], "error: there is no")],
)
def test_why_a_campaign_has_no_result_is_said(
    options: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make(tmp_path / "trial", 1)
    for _ in range(2):  # of a result that was there before, too
        ended = main(["identify", str(tmp_path / "trial"), "--into", str(tmp_path / "into"), "--sequential", "--", *options])
        told = capsys.readouterr().err
        assert ended in (1, 2) and words in told and "error: error" not in told

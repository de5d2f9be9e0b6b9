"""Campaigns from tables of pandas, polars and pyarrow, and to pandas."""

from pathlib import Path
from typing import Any

import elastogeo
import numpy as np
import pandas
import pytest

ABOUT: dict[str, Any] = {
    "robot": "kuka-kr270",
    "sigma": 1e-4,
    "estimate": {"base": True, "tool": True},
}


def made_with(library: str, frame: pandas.DataFrame) -> Any:
    if library == "pandas":
        return frame
    if library == "dict":
        return frame.to_dict("list")
    module = pytest.importorskip("pyarrow" if library == "stream" else library)
    if library == "polars":
        return module.DataFrame(frame.to_dict("list"))
    table = module.table(frame.to_dict("list"))
    return table if library == "pyarrow" else Stream(table)


class Stream:
    """A table that has the Arrow interface and nothing else."""

    def __init__(self, table: Any) -> None:
        self.table = table

    def __arrow_c_stream__(self, requested_schema: object = None) -> Any:
        return self.table.__arrow_c_stream__(requested_schema)


@pytest.mark.parametrize("library", ["pandas", "polars", "pyarrow", "stream", "dict"])
def test_there_and_back(library: str) -> None:
    frame = elastogeo.Campaign("kr270-simulated").to_pandas()
    campaign = elastogeo.Campaign.from_table(made_with(library, frame), **ABOUT)
    pandas.testing.assert_frame_equal(campaign.to_pandas(), frame)
    assert len(campaign) == 270 and campaign.robot == "kuka-kr270"


def test_a_table_is_calibrated_as_its_file() -> None:
    frame = elastogeo.Campaign("kr270-simulated").to_pandas()
    found = elastogeo.identify(elastogeo.Campaign.from_table(frame, **ABOUT))
    wanted = elastogeo.identify("kr270-simulated")
    assert found.kept == wanted.kept
    values, expected = (np.array([each.values[name] for name in wanted.kept]) for each in (found, wanted))
    assert np.allclose(values, expected, rtol=1e-6, atol=1e-5)


def test_units_and_missing_cells(tmp_path: Any) -> None:
    table = {
        "pose": ["a", "b"], "q1": [0, 90.0], "q2": [0, 0], "q3": [0, 0], "q4": [0, 0], "q5": [0, 0], "q6": [0.0, 0],
        "x": [1.0, 2], "y": [1.0, 2], "z": [1, 2], "temperature": [20.0, None],
    }  # fmt: skip
    units = {"length": "mm", "angle": "deg"}
    with pytest.raises(elastogeo.Error, match="temperature"):
        elastogeo.Campaign.from_table(table, robot="universal-ur5", units=units)
    del table["temperature"]
    campaign = elastogeo.Campaign.from_table(table, robot="universal-ur5", units=units, folder=tmp_path / "kept")
    assert np.allclose(campaign.to_dict()["q1"], [0, np.pi / 2]) and campaign.to_dict()["x"] == [1e-3, 2e-3]
    assert len(elastogeo.Campaign(tmp_path / "kept")) == 2


def test_columns_of_unequal_length() -> None:
    table = elastogeo.Campaign("kr270-simulated").to_dict()
    table["x"].pop()
    with pytest.raises(ValueError, match="pose 270.*x 269"):
        elastogeo.Campaign.from_table(table, **ABOUT)


@pytest.mark.parametrize("index", ["pose", ["pose", "marker"]])
def test_an_index_of_pandas_is_a_column(index: Any) -> None:
    frame = elastogeo.Campaign("kr270-simulated").to_pandas()
    campaign = elastogeo.Campaign.from_table(frame.set_index(index), **ABOUT)
    pandas.testing.assert_frame_equal(campaign.to_pandas()[frame.columns], frame)
    assert len(campaign.poses) == 30


def test_to_polars_and_pyarrow() -> None:
    polars, pyarrow = pytest.importorskip("polars"), pytest.importorskip("pyarrow")
    campaign = elastogeo.Campaign("kr270-simulated")
    wanted = campaign.to_dict()
    assert campaign.to_arrow().to_pydict() == campaign.to_polars().to_dict(as_series=False) == wanted
    assert pyarrow.table(campaign).to_pydict() == wanted
    assert polars.DataFrame(campaign).to_dict(as_series=False) == wanted
    again = elastogeo.Campaign.from_table(campaign, **ABOUT)
    assert again.to_dict() == wanted


def test_what_is_missing_is_null_in_arrow() -> None:
    pytest.importorskip("polars"), pytest.importorskip("pyarrow")
    made = elastogeo.Campaign("kr270-simulated")
    made.to_dict = lambda: {"pose": ["a", "b"], "x": [1.0, float("nan")]}  # type: ignore[method-assign]
    assert made.to_arrow().to_pydict()["x"] == made.to_polars().to_dict(as_series=False)["x"] == [1.0, None]


def test_a_folder_of_another_campaign_is_spared(tmp_path: Path) -> None:
    frame = elastogeo.Campaign("kr270-simulated").to_pandas()
    (tmp_path / "campaign.yaml").write_text("campaign: mine\n")
    with pytest.raises(FileExistsError, match="campaign.yaml of its own"):
        elastogeo.Campaign.from_table(frame, folder=tmp_path, **ABOUT)
    assert (tmp_path / "campaign.yaml").read_text() == "campaign: mine\n"
    assert not (tmp_path / "measurements.csv").exists()
    elastogeo.Campaign.from_table(frame, folder=tmp_path, force=True, **ABOUT)
    # What it wrote itself is replaced, unless somebody edited it.
    assert len(elastogeo.Campaign.from_table(frame[:60], folder=tmp_path, **ABOUT)) == 60
    for name in ("campaign.yaml", "measurements.csv"):
        before = (tmp_path / name).read_text()
        (tmp_path / name).write_text(before + "\n")
        with pytest.raises(FileExistsError, match="edited since"):
            elastogeo.Campaign.from_table(frame, folder=tmp_path, **ABOUT)
        (tmp_path / name).write_text(before)
    (tmp_path / "campaign.yaml").unlink()
    with pytest.raises(FileExistsError, match="measurements.csv of its own"):
        elastogeo.Campaign.from_table(frame, folder=tmp_path, **ABOUT)


def test_numbers_of_numpy() -> None:
    frame = elastogeo.Campaign("kr270-simulated").to_pandas()
    about = ABOUT | {"sigma": np.float32(1e-4), "estimate": {"base": np.bool_(True), "tool": np.bool_(True)}}
    campaign = elastogeo.Campaign.from_table(frame, **about)
    whole = {"sigma": np.int64(1), "units": {"length": "m", "angle": "rad"}}
    assert len(elastogeo.Campaign.from_table(frame, **(ABOUT | whole))) == len(campaign) == 270
    found = elastogeo.identify(campaign, seed=np.int64(2), loss="huber", loss_scale=np.float64(2), prior=np.bool_(False))  # type: ignore[arg-type]
    assert found["kept_parameters"] == elastogeo.identify(campaign, seed=2, loss="huber", loss_scale=2).kept
    with pytest.raises(TypeError, match="cannot stand in a campaign file"):
        elastogeo.Campaign.from_table(frame, **(ABOUT | {"estimate": {"base": object()}}))


def test_a_single_marker_is_one_name() -> None:
    frame = elastogeo.Campaign("kr270-simulated").to_pandas().query("marker == 'm1'").drop_duplicates("pose")
    frame = frame.drop(columns="marker").rename(columns={axis: f"ball_{axis}" for axis in "xyz"})
    with pytest.raises(elastogeo.Error, match="`ball`"):  # the robot has no such marker
        elastogeo.Campaign.from_table(frame, markers="ball", **ABOUT)
    frame = frame.rename(columns={f"ball_{axis}": f"m1_{axis}" for axis in "xyz"})
    assert len(elastogeo.Campaign.from_table(frame, markers="m1", **ABOUT)) == 30


def test_faults_of_a_table_name_its_rows(tmp_path: Path) -> None:
    frame = elastogeo.Campaign("kr270-simulated").to_pandas().astype({"x": object})
    frame.loc[3, "x"], frame.loc[5, "q1"] = "one", float("nan")
    with pytest.raises(elastogeo.Error) as raised:
        elastogeo.Campaign.from_table(frame, **ABOUT)
    first, second = raised.value.diagnostics
    assert "row 3 of the table: column `x`" in first["message"] and (first["row"], second["row"]) == (3, 5)
    assert "row 5 of the table: empty cell in column `q1`" in str(raised.value) and "measurements.csv" not in str(raised.value)
    for table, more, words in [
        (frame.drop(columns="x"), {}, "the table: the column `x` is missing"),
        (frame, {"observes": "posititon"}, "error: unknown kind of readings `posititon`"),
    ]:
        with pytest.raises(elastogeo.Error, match=words) as raised:
            elastogeo.Campaign.from_table(table, **(ABOUT | more))
        assert "elastogeo-" not in str(raised.value) + str(raised.value.diagnostics)
    # Files that stay are named.
    with pytest.raises(elastogeo.Error, match=r"measurements.csv:5"):
        elastogeo.Campaign.from_table(frame, folder=tmp_path, **ABOUT)


def test_what_is_no_table() -> None:
    with pytest.raises(TypeError, match="Arrow"):
        elastogeo.Campaign.from_table(3, robot="universal-ur5")


def test_the_robot_of_a_result(tmp_path: Any) -> None:
    found = elastogeo.identify("kr270-simulated", save=tmp_path / "calibrated.yaml")
    assert found.file is not None
    robot = elastogeo.Robot(found.file)
    value = robot.parameters.set_index("name").loc["3.d", "nominal"]
    assert value == pytest.approx(1e-3 * found.values["3.d"], abs=1e-12)


def test_several_markers_in_a_row() -> None:
    long = elastogeo.Campaign("kr270-simulated").to_pandas().query("marker != ''").drop_duplicates(["pose", "marker"])
    joints = [f"q{k}" for k in range(1, 7)]
    wide = long.pivot(index="pose", columns="marker", values=["x", "y", "z"])
    wide.columns = [f"{marker}_{axis}" for axis, marker in wide.columns]
    wide = wide.join(long.set_index("pose")[joints].groupby(level=0).first()).reset_index()
    campaign = elastogeo.Campaign.from_table(wide, markers=["m1", "m2", "m3"], **ABOUT)
    again = campaign.to_pandas().sort_values(["pose", "marker"], ignore_index=True)
    columns = ["pose", "marker", *joints, "x", "y", "z"]
    before = long.sort_values(["pose", "marker"], ignore_index=True)
    pandas.testing.assert_frame_equal(again[columns], before[columns], rtol=0, atol=1e-9)


def test_formats_of_convert(tmp_path: Any) -> None:
    robot = elastogeo.Robot("universal-ur5")
    with pytest.raises(elastogeo.Error, match="may be an MJCF or a URDF.*mjcf"):
        robot.convert(tmp_path / "arm.xml")
    with pytest.raises(elastogeo.Error, match="yaml.*urdf.*mjcf.*ur-kinematics"):
        robot.convert(tmp_path / "arm.txt")
    for name, starts in (("mjcf", "<mujoco"), ("urdf", "<?xml"), ("yaml", "robot:"), ("ur-kinematics", "kinematics:")):
        robot.convert(tmp_path / "arm.xml", format=name)  # type: ignore[arg-type]
        text = (tmp_path / "arm.xml").read_text()
        assert any(line.startswith(starts) for line in text.splitlines())

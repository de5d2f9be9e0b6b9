"""Campaigns from tables of pandas, polars and pyarrow, and to pandas."""

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


def test_what_is_no_table() -> None:
    with pytest.raises(TypeError, match="Arrow"):
        elastogeo.Campaign.from_table(3, robot="universal-ur5")


def test_the_robot_of_a_result(tmp_path: Any) -> None:
    found = elastogeo.identify("kr270-simulated", save=tmp_path / "calibrated.yaml")
    assert found.file is not None
    robot = elastogeo.Robot(found.file)
    value = robot.parameters.set_index("name").loc["3.d", "nominal"]
    assert value == pytest.approx(1e-3 * found.values["3.d"], abs=1e-12)

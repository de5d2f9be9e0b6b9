"""The package itself: types, examples of the documentation, notebooks, the command."""

import doctest
import importlib
import json
import pkgutil
import subprocess
import sys
from pathlib import Path

import elastogeo
import pytest

ROOT = Path(__file__).parents[2]


def test_types() -> None:
    pytest.importorskip("mypy")
    ran = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "-p", "elastogeo"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stdout + ran.stderr


def test_types_as_pyright_sees_them(tmp_path: Path) -> None:
    pytest.importorskip("basedpyright")
    (tmp_path / "pyrightconfig.json").write_text(json.dumps({"typeCheckingMode": "standard", "include": list(elastogeo.__path__)}))
    command = [sys.executable, "-m", "basedpyright", "--level", "error", "--pythonpath", sys.executable, "-p", str(tmp_path)]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr


def test_types_of_the_tests() -> None:
    pytest.importorskip("mypy")
    ran = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", str(ROOT / "python/tests")],
        capture_output=True, text=True, check=False, cwd=ROOT / "python/tests",
    )  # fmt: skip
    assert ran.returncode == 0, ran.stdout + ran.stderr


def modules() -> list[str]:
    found = [module.name for module in pkgutil.iter_modules(elastogeo.__path__)]
    return ["elastogeo", *(f"elastogeo.{name}" for name in found if name not in ("__main__", "_native"))]


@pytest.mark.parametrize("name", modules())
def test_examples_of_the_code(name: str) -> None:
    module = importlib.import_module(name)
    import numpy

    assert doctest.testmod(module, extraglobs={"np": numpy}).failed == 0


@pytest.mark.parametrize(("page", "least"), [("docs/python.md", 10), ("README.md", 2)])
def test_examples_of_the_pages(page: str, least: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    found = doctest.testfile(str(ROOT / page), module_relative=False, optionflags=doctest.ELLIPSIS)
    assert found.attempted > least and found.failed == 0


@pytest.mark.parametrize("notebook", sorted((ROOT / "python/notebooks").glob("*.ipynb")), ids=lambda path: path.stem)
def test_notebooks_run(notebook: Path, tmp_path: Path) -> None:
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    content = nbformat.read(notebook, as_version=4)
    assert not any(cell.get("outputs") for cell in content.cells), "notebooks are kept without outputs"
    nbclient.NotebookClient(content, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()


def test_the_command() -> None:
    command = Path(sys.executable).parent / "elastogeo"
    whole = [str(command)] if command.exists() else [sys.executable, "-m", "elastogeo"]
    ran = subprocess.run([*whole, "--version"], capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stdout.split()) == (0, ["elastogeo", elastogeo.__version__])
    for arguments, status in ((["explain", "rank"], 0), (["check", "no-such-robot"], 2), (["--nonsense"], 2)):
        ran = subprocess.run([*whole, *arguments], capture_output=True, text=True, check=False)
        assert ran.returncode == status, ran.stderr


def test_log(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Commands tell `logging` that they begin and end, and what they warn of."""
    elastogeo.simulate("universal-ur5", 12, tmp_path / "few", noise=0.05, seed=3, unknown_base=True)
    with caplog.at_level("DEBUG", logger="elastogeo"):
        caplog.clear()
        found = elastogeo.identify(tmp_path / "few")
        told = [(each.levelname, each.getMessage()) for each in caplog.records if each.name == "elastogeo"]
    assert told[0][0] == "DEBUG" and told[0][1].startswith("identify begins") and "few" in told[0][1]
    assert told[-1][0] == "INFO" and told[-1][1].startswith("identify ends after")
    warned = [message for level, message in told if level == "WARNING"]
    expected = [each for each in found.diagnostics if each["severity"] == "warning"]
    assert expected and warned == [f"identify: {each['message']} ({each['remedy']})" for each in expected]
    with caplog.at_level("INFO", logger="elastogeo"), pytest.raises(elastogeo.Error):
        caplog.clear()
        elastogeo.identify(tmp_path / "few", loss="huuber")
    assert [each.levelname for each in caplog.records] == ["INFO"] and "huuber" in caplog.records[0].getMessage()


def test_nothing_is_printed_without_a_log(tmp_path: Path) -> None:
    program = f"import elastogeo\nelastogeo.simulate('universal-ur5', 12, {str(tmp_path / 'few')!r}, noise=0.05, unknown_base=True)\n"
    program += f"assert elastogeo.identify({str(tmp_path / 'few')!r}).diagnostics"
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "", "")

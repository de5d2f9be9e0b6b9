"""What the tests share."""

import json
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

# A runner in the background passes SIGINT on as ignored, to the programs that tests start too.
signal.signal(signal.SIGINT, signal.default_int_handler)

Command = Callable[..., dict[str, Any]]


@pytest.fixture
def command() -> Command:
    """Runs the command of the package in a process of its own: its JSON."""

    def run(*arguments: str) -> dict[str, Any]:
        whole = [sys.executable, "-m", "elastogeo", *arguments, "--format=json"]
        ran = subprocess.run(whole, capture_output=True, text=True, check=False)
        found: dict[str, Any] = json.loads(ran.stdout)
        return found

    return run


@pytest.fixture
def bad_campaign(tmp_path: Path) -> Path:
    """A campaign with two faults: an unknown column, and a word for a number."""
    (tmp_path / "campaign.yaml").write_text(
        "campaign: bad\nrobot: universal-ur5\nunits: {length: mm, angle: deg}\nmeasurements: m.csv\n"
    )
    (tmp_path / "m.csv").write_text("pose,q1,q2,q3,q4,q5,q6,x,y,zz\na,0,0,0,0,0,0,one,2,3\n")
    return tmp_path

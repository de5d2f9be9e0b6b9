#!/usr/bin/env python3
"""Records the figures of the docs that take too long for every test run: docs/figures/make.py PROGRAM RECORD..

Each record is a text, docs/figures/RECORD.txt, whose first line is the command that made it; tests/it/figures.rs holds the
docs against it. Records that a test makes are rewritten by `ELASTOGEO_FIGURES=write cargo test`.

  planning    what plans of 18 configurations buy, docs/planning.md (3 minutes)
  real-data   `diagnose` on measured data in $ELASTOGEO_DATA or ../shared/data, docs/real-data.md (5 minutes)
  benches     what `cargo bench` prints, docs/accuracy.md (10 minutes, the machine otherwise idle)
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..")

ARMS = {
    "UR5": ["universal-ur5", "--unknown-base", "--unknown-tool"],
    "IR663": ["kuka-ir663", "--observes", "pose"],
    "KR-270": ["kuka-kr270", "--markers", "m1,m2,m3", "--unknown-base", "--unknown-tool"],
}
# Half widths of the workpiece's ranges; the region is twice as wide.
CENTRES = {
    "UR5": [("q1", 0, 15), ("q2", -90, 15), ("q3", 90, 15), ("q4", -120, 15), ("q5", -90, 10), ("q6", 0, 30)],
    "IR663": [("q1", 0, 15), ("stroke2", 800, 50), ("stroke8", 750, 50), ("q4", 0, 20), ("q5", 90, 15), ("q7", 0, 30)],
    "KR-270": [("q1", 0, 15), ("q2", -85, 13), ("q3", 85, 13), ("q4", 0, 20), ("q5", 45, 13), ("q6", 0, 30)],
}
REGIONS = {"joint box": 0, "working region": 2, "workpiece": 1}
DATA = {"UR5": "ur5-jacobi", "UR10": "ur10-landgraf", "WAM": "wam-jacobi"}
CALIBRATED = {
    "as described": None,
    "geometry": "calibrate: [geometry, joint-offset]\n",
    "and joint compliance": "calibrate: [geometry, joint-offset, joint-compliance]\n",
}


def run(program, *arguments):
    return subprocess.run([program, *arguments], check=True, capture_output=True, text=True).stdout


def write(name, command, lines):
    with open(os.path.join(HERE, f"{name}.txt"), "w", encoding="utf-8") as file:
        file.write("\n".join([f"$ {command}", *lines]) + "\n")


def planning(program):
    lines = []
    for arm, flags in ARMS.items():
        for region, width in REGIONS.items():
            ranges = ",".join(f"{name}={at - width * half}:{at + width * half}" for name, at, half in CENTRES[arm])
            where = ["--test-range", ranges] if width else []
            said = run(program, "plan", flags[0], "--poses", "18", *flags[1:], *where)
            planned, random = re.findall(r"leaves? (\d+\.\d+) mm", said)
            equal = re.search(r"(\d+) at random to do as well", said)[1]
            lines.append(f"{arm}, {region}: {planned} mm planned, {random} mm random, {equal} random do as well")
            print(lines[-1])
    write("planning", "docs/figures/make.py PROGRAM planning", lines)


def real_data(program):
    root = os.environ.get("ELASTOGEO_DATA", os.path.join(ROOT, "..", "shared", "data"))
    for arm, name in DATA.items():
        for what, line in CALIBRATED.items():
            with tempfile.TemporaryDirectory() as folder:
                campaign = os.path.join(folder, name)
                shutil.copytree(os.path.join(root, name), campaign)
                with open(os.path.join(campaign, "campaign.yaml"), "a", encoding="utf-8") as file:
                    file.write(line or "")
                found = run(program, "diagnose", campaign)
            added = f" with `{line.strip()}`" if line else ""
            write(f"diagnose-{name}-{what.replace(' ', '-')}", f"elastogeo diagnose {name}{added}", found.splitlines())
            print(arm, what, found.splitlines()[2])


def benches(_program):
    lines = []
    for bench in ["evaluation", "elastics", "identification", "compensation", "diagnosis"]:
        out = run("cargo", "bench", "--manifest-path", os.path.join(ROOT, "Cargo.toml"), "--bench", bench)
        # The lines below divan's own table.
        lines += [line for line in out.splitlines() if re.match(r"\S.*\d", line) and "│" not in line]
    write("benches", "docs/figures/make.py PROGRAM benches", lines)


def main():
    program = os.path.abspath(sys.argv[1])
    for name in sys.argv[2:]:
        {"planning": planning, "real-data": real_data, "benches": benches}[name](program)


if __name__ == "__main__":
    main()

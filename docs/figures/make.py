#!/usr/bin/env python3
"""Records the figures of the docs that take too long for every test run: docs/figures/make.py PROGRAM RECORD..

Each record is a text, docs/figures/RECORD.txt, whose first line is the command that made it; tests/it/figures.rs holds the
docs against it. Records that a test makes are rewritten by `ELASTOGEO_FIGURES=write cargo test`.

docs/figures/make.py campaigns FOLDER writes the campaign files of the measured data, to be used by hand.

  planning    what plans of 18 configurations buy, docs/planning.md (3 minutes)
  real-data   `diagnose` on measured data in $ELASTOGEO_DATA or ../shared/data, docs/real-data.md (5 minutes)
  evidence    `identify` on measured data, sockets, sessions, torques, reflectors and the order, docs/real-data.md (5 minutes)
  benches     what `cargo bench` prints, docs/accuracy.md (10 minutes, the machine otherwise idle)
  python      what `python/benches/calls.py` prints, docs/python.md (half a minute, with the Python package and Pinocchio)
  fleet       what a campaign of a fleet takes, docs/fleet.md (2 minutes; with the Python package of `pip install '.[fleet]'`)
"""

import os
import re
import resource
import subprocess
import sys
import tempfile
import time

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
    "-as-described": "calibrate: []\n",
    "-geometry": "calibrate: [geometry, joint-offset]\n",
}
# Two springs of the base, where it stands on something that gives.
TILT = "base_stiffness: {{krx: {{compliance: 1.0e-5, identifiable: true}}, kry: {{compliance: 1.0e-5, identifiable: true}}}}\n"
# Descriptions of the iiwa 7: rigid; with joint springs; with the tilt of the base; with the wind-up of joints 2 and 4.
ARMS_OF_RUNS = {"-rigid": 0, "": 1, "-tilting": 2, "-winding": 3}


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
    with tempfile.TemporaryDirectory() as folder:
        campaigns(folder, root)
        for name in DATA.values():
            for what in CALIBRATED:
                found = run(program, "diagnose", os.path.join(folder, f"{name}{what}.yaml"))
                write(f"diagnose-{name}{what}", f"elastogeo diagnose {name}{what}.yaml", found.splitlines())
                print(name, what, found.splitlines()[2])


ARM = "robot: arm\nurdf: {{file: {data}/panda-socket/{urdf}, to: ball_link}}\n"
SOCKETS = """robot: {arm}-arm.yaml
units: {{length: m, angle: rad}}
observes: contact
instrument: {{sigma: 5.0e-4}}
estimate: {{tool: true}}
contacts: {{socket0: {{kind: socket, group: placement}}, socket1: {{kind: socket, group: placement}}}}
distances: {{socket0-socket1: 0.05}}
measurements: {data}/panda-socket/{file}
columns: {{contact: socket}}
"""
RUNS = """robot: springs.yaml
units: {{length: mm, angle: rad}}
observes: pose
instrument: {{sigma: 0.3, orientation: 1.0e-3}}
estimate: {{base: per-session, tool: per-session}}
calibrate: [geometry, joint-offset]
payloads: {{five: {{mass: 5, com: [0, 0, 50], frame: "7"}}}}
measurements:
- {{file: {data}/iiwa7-payload/unloaded.csv, session: unloaded}}
- {{file: {data}/iiwa7-payload/payload-0kg.csv, session: zero}}
- {{file: {data}/iiwa7-payload/payload-5kg.csv, session: five, payload: five}}
ignore: [torque.q1, torque.q2, torque.q3, torque.q4, torque.q5, torque.q6, torque.q7]
"""
TORQUES = """robot: {data}/iiwa7-payload/robot.yaml
units: {{length: mm, angle: rad}}
observes: [pose, torque]
instrument: {{sigma: 0.3, orientation: 1.0e-3, torque: 1}}
estimate: {{base: true, tool: true}}
torques:
  q2: {{gain: unknown, offset: unknown}}
  q3: {{gain: unknown, offset: unknown}}
  q4: {{gain: unknown, offset: unknown}}
  q5: {{gain: unknown, offset: unknown}}
  q6: {{gain: unknown, offset: unknown}}
measurements: {data}/iiwa7-payload/unloaded.csv
"""
TRACKER = """robot: {data}/irb120-faro/robot.yaml
units: {{length: mm, angle: deg}}
observes: position
estimate: {{base: true, tool: true}}
calibrate: [geometry, joint-offset, joint-compliance]
measurements: {data}/irb120-faro/measurements.csv
references: {data}/irb120-faro/base-reflectors.csv
"""


def campaigns(folder, data):
    """Writes a campaign file for each table of docs/real-data.md into `folder`; `data` holds the measured files."""
    data = os.path.abspath(data)
    os.makedirs(folder, exist_ok=True)

    def save(name, text, **values):
        with open(os.path.join(folder, f"{name}.yaml"), "w", encoding="utf-8") as file:
            file.write(text.format(data=data, **values))

    for name in DATA.values():
        with open(os.path.join(data, name, "campaign.yaml"), encoding="utf-8") as file:
            text = file.read().replace("measurements: ", f"measurements: {data}/{name}/")
        for what, line in CALIBRATED.items():
            with open(os.path.join(folder, f"{name}{what}.yaml"), "w", encoding="utf-8") as file:
                file.write(text + line)
    for arm, urdf, file in [("panda_1", "panda.urdf", "panda_1.csv"), ("kuka_14", "iiwa14.urdf", "kuka_14.csv")]:
        save(f"{arm}-arm", ARM, urdf=urdf)
        save(arm, SOCKETS, arm=arm, file=file)
        free = SOCKETS.replace("socket0-socket1: 0.05", "socket0-socket1: unknown")
        save(f"{arm}-free", free, arm=arm, file=file)
        # With masses and springs, of the joints that carry weight.
        with open(os.path.join(ROOT, "tests", "data", "sockets", urdf.replace("urdf", "yaml")), encoding="utf-8") as masses:
            heavy = ARM + masses.read().replace("{", "{{").replace("}", "}}")
        save(f"{arm}-weight-arm", heavy, urdf=urdf)
        save(f"{arm}-tilting-arm", heavy + TILT, urdf=urdf)
        for name in ["weight", "tilting"]:
            save(f"{arm}-{name}", SOCKETS, arm=f"{arm}-{name}", file=file)
            save(f"{arm}-{name}-free", free, arm=f"{arm}-{name}", file=file)
    with open(os.path.join(data, "iiwa7-payload", "robot.yaml"), encoding="utf-8") as file:
        description = file.read().replace("{", "{{").replace("}", "}}")
    springs = "".join(f"  {k}: {{{{kar: {{{{compliance: 5.0e-5, identifiable: true}}}}}}}}\n" for k in range(2, 7))
    springs = "joint_stiffness:\n" + springs
    # The tilt of the base that `diagnose` names in the three runs, then the wind-up of joint 4 that it names next, and that of
    # joint 2, from which it cannot tell it.
    wind_up = "- {{{{effect: joint-stiffening, site: 'joint:{}', parameters: {{{{wind_up: 1.0e-4, wound_up_at: 11.28}}}}}}}}\n"
    wind_up = "effects:\n" + "".join(wind_up.format(k) for k in (2, 4))
    alone = RUNS[: RUNS.index("measurements:")].replace("per-session", "true")
    ignored = RUNS[RUNS.index("ignore:") :]
    for kind, more in ARMS_OF_RUNS.items():
        arm = f"{kind or '-springs'}"[1:]
        save(arm, description + (springs if more else "") + (TILT if more > 1 else "") + (wind_up if more > 2 else ""))
        save(f"iiwa7-runs{kind}", RUNS.replace("springs.yaml", f"{arm}.yaml"))
        for run_, load in [("unloaded", ""), ("payload-0kg", ""), ("payload-5kg", ", payload: five")]:
            entry = f"measurements: {{{{file: {{data}}/iiwa7-payload/{run_}.csv{load}}}}}\n"
            save(f"iiwa7-{run_}{kind}", (alone + entry + ignored).replace("springs.yaml", f"{arm}.yaml"))
    save("iiwa7-torques", TORQUES)
    save("irb120", TRACKER)
    rigid = TRACKER.replace(", joint-compliance]", "]")
    with open(os.path.join(data, "irb120-faro", "robot.yaml"), encoding="utf-8") as file:
        save("irb120-springs", file.read().replace("{", "{{").replace("}", "}}") + springs)
    for kind, more in {"": "", "-commanded": "joints: commanded\n"}.items():
        save(f"irb120{kind}-geometry", rigid + more)
        save(f"irb120{kind}-compliant", rigid.replace("{data}/irb120-faro/robot.yaml", "irb120-springs.yaml") + more)


def evidence(program):
    data = os.path.abspath(os.environ.get("ELASTOGEO_DATA", os.path.join(ROOT, "..", "shared", "data")))
    with tempfile.TemporaryDirectory() as folder:
        campaigns(folder, data)

        def record(name, *command):
            command = [os.path.join(folder, part) if part.endswith(".yaml") else part for part in command]
            found = run(program, *command).replace(folder + "/", "").replace(data + "/", "")
            told = " ".join(command).replace(folder + "/", "")
            write(name, "elastogeo " + told, [line.rstrip() for line in found.splitlines()])
            print(name, found.splitlines()[2])

        for name in DATA.values():
            record(f"identify-{name}", "identify", f"{name}-geometry.yaml")
        for arm in ["panda_1", "kuka_14"]:
            record(f"sockets-{arm}", "identify", f"{arm}.yaml")
            record(f"sockets-{arm}-free", "identify", f"{arm}-free.yaml", "--tolerance", "noise")
            for name in ["weight", "weight-free", "tilting", "tilting-free"]:
                record(f"sockets-{arm}-{name}", "identify", f"{arm}-{name}.yaml", "--what", "geometric,elastic")
        fit = ["--what", "geometric,elastic", "--tolerance", "noise"]
        for run_ in ["unloaded", "payload-0kg", "payload-5kg"]:
            record(f"alone-iiwa7-{run_}-rigid", "identify", f"iiwa7-{run_}-rigid.yaml", "--tolerance", "noise")
        for kind in ["", "-tilting", "-winding"]:
            record(f"sessions-iiwa7{kind}", "identify", f"iiwa7-runs{kind}.yaml", *fit)
            for run_ in ["unloaded", "payload-0kg", "payload-5kg"]:
                record(f"alone-iiwa7-{run_}{kind}", "identify", f"iiwa7-{run_}{kind}.yaml", *fit)
        record("torques-iiwa7", "identify", "iiwa7-torques.yaml")
        record("reflectors-irb120", "check", "irb120.yaml")
        for kind in ["", "-commanded"]:
            record(f"irb120{kind}-geometry", "identify", f"irb120{kind}-geometry.yaml")
            record(f"irb120{kind}-compliant", "identify", f"irb120{kind}-compliant.yaml", "--what", "geometric,elastic")
        record("order-irb120", "diagnose", "irb120.yaml")
        record("lags-irb120", "diagnose", "irb120-geometry.yaml")
        record("springs-irb120", "diagnose", "irb120-commanded-geometry.yaml")


def benches(_program):
    lines = []
    for bench in ["evaluation", "elastics", "identification", "compensation", "diagnosis"]:
        out = run("cargo", "bench", "--manifest-path", os.path.join(ROOT, "Cargo.toml"), "--bench", bench)
        # The lines below divan's own table.
        lines += [line for line in out.splitlines() if re.match(r"\S.*\d", line) and "│" not in line]
    write("benches", "docs/figures/make.py PROGRAM benches", lines)


def python(_program):
    out = run(sys.executable, os.path.join(ROOT, "python", "benches", "calls.py"))
    write("python", "docs/figures/make.py PROGRAM python", out.splitlines())


def fleet(program):
    count, poses = 100, 30
    lines = [f"{count} simulated campaigns of universal-ur5, {poses} configurations, base and tool unknown, two workers"]
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(1, count + 1):
            into = os.path.join(folder, "robots", f"arm-{seed:03}")
            arm = ["simulate", "universal-ur5", "--poses", str(poses), "--into", into, "--seed", str(seed)]
            run(program, *arm, "--noise", "0.05", "--unknown-base", "--unknown-tool")
        for command in ["identify", "diagnose"]:
            results = os.path.join(folder, command)
            before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
            whole = [command, os.path.join(folder, "robots"), "--into", results, "--workers", "2"]
            run(sys.executable, "-m", "elastogeo.fleet", *whole)
            seconds, after = time.monotonic() - started, resource.getrusage(resource.RUSAGE_CHILDREN)
            busy = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            size = sum(entry.stat().st_size for entry in os.scandir(results)) / 1024
            lines.append(
                f"{command}: {busy / count:.3f} processor seconds a campaign, start of the processes included: "
                f"{count / busy:.1f} a second and core; {size / count:.0f} kB in the dataset; {seconds:.0f} s in all"
            )
            print(lines[-1])
    write("fleet", "docs/figures/make.py PROGRAM fleet", lines)


def main():
    if sys.argv[1] == "campaigns":
        return campaigns(sys.argv[2], os.environ.get("ELASTOGEO_DATA", os.path.join(ROOT, "..", "shared", "data")))
    program = os.path.abspath(sys.argv[1])
    for name in sys.argv[2:]:
        makers = {"planning": planning, "real-data": real_data, "evidence": evidence, "benches": benches}
        makers |= {"python": python, "fleet": fleet}
        makers[name](program)


if __name__ == "__main__":
    main()

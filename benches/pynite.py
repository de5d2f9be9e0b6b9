"""Time of one linear analysis of a frame by PyNite, for benches/elastics.rs, which writes the frame to standard input.

    pip install PyNiteFEA scipy

SI units. A member's local z is the stated vector made square to it, as in tests/data/pynite/make.py; `hinges` says at
which of its ends it turns freely about that z. The best of several analyses is printed: assembly, solution and the
displacement, the model being built already.
"""

import json
import sys
import time

import numpy as np
import Pynite


def build(frame):
    model = Pynite.FEModel3D()
    for name, at in frame["nodes"]:
        model.add_node(name, *at)
    for k, m in enumerate(frame["members"]):
        name = f"m{k}"
        model.add_material(name, m["E"], m["G"], nu=0.3, rho=0.0)
        model.add_section(name, m["A"], m["Iy"], m["Iz"], m["J"])
        model.add_member(name, m["from"], m["to"], name, name)
        x, y, z = model.members[name].T()[:3, :3]
        wanted = np.array(m["local_z"])
        wanted = wanted - (wanted @ x) * x
        model.members[name].rotation = np.degrees(np.arctan2(-y @ wanted, z @ wanted))
        if any(m["hinges"]):
            model.def_releases(name, Rzi=m["hinges"][0], Rzj=m["hinges"][1])
    model.def_support(frame["held"], *[True] * 6)
    for direction, force in zip(["FX", "FY", "FZ"], frame["force"]):
        model.add_node_load(frame["loaded"], direction, force)
    return model


def main():
    frame = json.load(sys.stdin)
    model = build(frame)
    node = model.nodes[frame["loaded"]]
    best = float("inf")
    for sparse in [False, True]:
        for _ in range(20):
            start = time.perf_counter()
            model.analyze_linear(sparse=sparse)
            moved = [node.DX["Combo 1"], node.DY["Combo 1"], node.DZ["Combo 1"]]
            best = min(best, time.perf_counter() - start)
    print(json.dumps({"moved": [float(v) for v in moved], "seconds": best}))


if __name__ == "__main__":
    main()

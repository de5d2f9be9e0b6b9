"""Writes frames.json: displacements of small 3-D frames as PyNite computes them (linear, Euler-Bernoulli).

    pip install PyNiteFEA scipy
    python make.py

SI units: m, N, Pa, rad. Global axes x, y, z with z up. 6-vectors are [translations; rotations] and
[forces; moments] in global axes.

Local axes of a member: x runs from its node `from` to its node `to`; z is the stated vector `local_z` less its part
along x, normalised; y = z cross x. Iz is the bending in the local x-y plane (about local z), Iy that in the local x-z
plane (about local y). A force along +y at the free end of a cantilever thus moves it by F L^3 / (3 E Iz) along y and
turns it by +F L^2 / (2 E Iz) about z; a force along +z, by F L^3 / (3 E Iy) along z and by -F L^2 / (2 E Iy) about y.

PyNite means the same by Iy and Iz, but chooses y and z itself (its global Y is up) and then turns them about x by
`rotation` degrees. `solve` finds that rotation and asserts that PyNite's axes are then those stated here.

Before anything is written, it is asserted that
  1. PyNite gives the textbook displacements of cantilevers in several directions (`check_cantilevers`);
  2. for every structure, it agrees with a second solution, which shares only the local axes with it (`assemble`);
  3. every structure notices Iy and Iz exchanged, and the hinge is noticed: the numbers can tell right from wrong.
"""

import json
from pathlib import Path

import numpy as np
import Pynite

DOFS = ["DX", "DY", "DZ", "RX", "RY", "RZ"]
LOADS = ["FX", "FY", "FZ", "MX", "MY", "MZ"]
CLAMPED, PINNED = [True] * 6, [True] * 3 + [False] * 3
GRAVITY = 9.80665

STEEL = {"E": 210e9, "G": 80.77e9}
ALUMINIUM = {"E": 70e9, "G": 26.3e9}
CARBON = {"E": 120e9, "G": 9e9}


# ------------------------------------------------------------------------------------------------ the structures

def node(name, *xyz):
    return {"name": name, "xyz": [float(c) for c in xyz]}


def member(start, end, local_z, material, area, iy, iz, j, **more):
    return {"name": f"{start}-{end}", "from": start, "to": end, "local_z": [float(c) for c in local_z],
            **material, "A": area, "Iy": iy, "Iz": iz, "J": j, **more}


def support(name, held):
    return {"node": name, "held": held}


def case(name, node_loads=(), member_loads=()):
    """Node loads are (node, 6-vector); member loads (member, force per unit of length, global, over all its length)."""
    return {"name": name,
            "node_loads": [{"node": n, "load": list(map(float, w))} for n, w in node_loads],
            "member_loads": [{"member": m, "force_per_length": list(map(float, q))} for m, q in member_loads]}


def structure(name, about, nodes, members, supports, cases):
    return {"name": name, "about": about, "nodes": nodes, "members": members, "supports": supports,
            "load_cases": cases}


def portal():
    nodes = [node("footL", 0, 0, 0), node("kneeL", 0, 0, 3), node("mid", 2, 0, 3), node("kneeR", 4, 0, 3),
             node("footR", 4, 0, 0)]
    girder = (STEEL, 4.59e-3, 4.49e-6, 77.6e-6, 2.1e-7)
    members = [
        member("footL", "kneeL", (0, 1, 0), STEEL, 5.43e-3, 20.0e-6, 57.0e-6, 2.0e-7),
        member("kneeL", "mid", (0, 1, 0), *girder),
        member("mid", "kneeR", (0, 1, 0), *girder),
        member("kneeR", "footR", (1, 2, 0), STEEL, 3.40e-3, 6.16e-6, 16.7e-6, 9.3e-8),
    ]
    loads = [("kneeL", (8e3, 0, 0, 0, 3e3, 0)), ("mid", (0, 0, -20e3, 0, 0, 0)), ("kneeR", (0, 2.5e3, 0, 0, 0, 0))]
    return structure("portal", "Two 3 m columns clamped at the foot, 4 m girder; lateral force and moment at the left "
                     "knee, vertical force at mid-span, force out of plane at the right knee.", nodes, members,
                     [support("footL", CLAMPED), support("footR", CLAMPED)], [case("loads", loads)])


def ring():
    normal = np.array([1.0, 2.0, 3.0])
    e2 = np.cross(normal, [1.0, 0.4, 0.1])
    e1 = np.cross(e2, normal)
    e1, e2 = e1 / np.linalg.norm(e1), e2 / np.linalg.norm(e2)
    angles = 2 * np.pi * np.arange(12) / 12
    nodes = [node(f"v{k}", *(0.5 * (np.cos(a) * e1 + np.sin(a) * e2) + [0.2, -0.1, 0.8])) for k, a in enumerate(angles)]
    members = [member(f"v{k}", f"v{(k + 1) % 12}", normal, ALUMINIUM, 6.0e-4, 8.0e-8, 3.5e-8, 6.5e-8)
               for k in range(12)]
    return structure("ring", "Regular 12-gon of radius 0.5 m in the plane normal to (1, 2, 3), clamped at v0; force "
                     "and moment at the opposite vertex v6.", nodes, members, [support("v0", CLAMPED)],
                     [case("loads", [("v6", (120, -80, -150, 15, 25, -10))])])


def box(hinged):
    nodes = [node(f"n{i}{j}{k}", i * 1.0, j * 0.8, k * 0.6) for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    sections = {"x": (STEEL, 5.41e-4, 1.34e-7, 2.54e-7, 2.9e-7), "y": (STEEL, 4.21e-4, 5.7e-8, 1.27e-7, 1.3e-7),
                "z": (ALUMINIUM, 7.4e-4, 2.1e-7, 1.1e-7, 2.6e-7)}
    # Some of these vectors stand askew of the member on purpose: they must be orthogonalised.
    members = [
        member("n000", "n100", (0, 0, 1), *sections["x"]), member("n010", "n110", (0.3, 0, 1), *sections["x"]),
        member("n001", "n101", (0, 1, 0), *sections["x"]), member("n011", "n111", (0.5, 1, 2), *sections["x"]),
        member("n000", "n010", (0, 0, 1), *sections["y"]), member("n110", "n100", (1, 0.7, 1), *sections["y"]),
        member("n001", "n011", (1, 0, 0), *sections["y"]), member("n111", "n101", (0, 0, -1), *sections["y"]),
        member("n000", "n001", (1, 0, 0), *sections["z"]), member("n101", "n100", (1, 2, 0), *sections["z"]),
        member("n010", "n011", (0, 1, 0), *sections["z"]), member("n110", "n111", (2, -1, 0.4), *sections["z"]),
        member("n110", "n001", (0, 0, 1), STEEL, 2.01e-4, 1.36e-8, 3.10e-8, 2.7e-8),
    ]
    about = "Box of 1 x 0.8 x 0.6 m: 12 edges, a body diagonal; n000, n100 clamped, n010 pinned; loads at two nodes."
    if hinged:
        members[3]["release"] = {"end": "to", "about": "z"}
        about = "The box, but the edge n011-n111 is hinged about its local z where it meets n111."
    return structure("box_hinged" if hinged else "box", about, nodes, members,
                     [support("n000", CLAMPED), support("n100", CLAMPED), support("n010", PINNED)],
                     [case("loads", [("n111", (900, -600, -1500, 40, -60, 80)), ("n011", (0, 1200, 500, -30, 0, 25))])])


def arm():
    nodes = [node("p0", 0, 0, 0), node("p1", 0, 0, 0.8), node("p2", 0.2, 0.1, 1.7), node("p3", 1.1, 0.5, 2.0),
             node("p4", 1.8, 0.3, 1.6), node("tip", 2.1, 0.1, 1.2)]
    members = [
        member("p0", "p1", (1, 0, 0), STEEL, 1.20e-2, 6.0e-5, 8.0e-5, 1.1e-4, rho=7850.0),
        member("p1", "p2", (1, 0, 0), STEEL, 8.0e-3, 2.5e-5, 4.0e-5, 5.0e-5, rho=7850.0),
        member("p2", "p3", (0, 0, 1), ALUMINIUM, 6.0e-3, 1.5e-5, 1.0e-5, 2.0e-5, rho=2700.0),
        member("p3", "p4", (0, 1, 1), CARBON, 2.5e-3, 2.0e-6, 3.5e-6, 4.0e-6, rho=1600.0),
        member("p4", "tip", (1, 1, 1), ALUMINIUM, 1.5e-3, 9.0e-7, 6.0e-7, 1.1e-6, rho=2700.0),
    ]
    weight = [(m["name"], (0, 0, -m["rho"] * m["A"] * GRAVITY)) for m in members]
    return structure("arm", "Cantilever of 5 unlike members along a polyline, clamped at p0: its own weight alone "
                     f"(rho A g along -z, g = {GRAVITY} m/s^2), and a wrench at the tip alone.", nodes, members,
                     [support("p0", CLAMPED)],
                     [case("own_weight", member_loads=weight),
                      case("wrench", [("tip", (300, -200, -700, 60, -40, 90))])])


# -------------------------------------------------------------------------------------------------- two solutions

def axes(s, m):
    """Length of member m, and its local axes as the rows of a 3x3 matrix."""
    at = {n["name"]: np.array(n["xyz"]) for n in s["nodes"]}
    x = at[m["to"]] - at[m["from"]]
    length = np.linalg.norm(x)
    x = x / length
    z = np.array(m["local_z"])
    z = z - (z @ x) * x
    z = z / np.linalg.norm(z)
    return length, np.array([x, np.cross(z, x), z])


def solve(s):
    """PyNite: for each load case, one row of 6 per node."""
    model = Pynite.FEModel3D()
    for n in s["nodes"]:
        model.add_node(n["name"], *n["xyz"])
    for m in s["members"]:
        name = m["name"]
        # nu and rho are not used in linear statics: G is given, weight enters as distributed loads.
        model.add_material(name, m["E"], m["G"], nu=0.3, rho=0.0)
        model.add_section(name, m["A"], m["Iy"], m["Iz"], m["J"])
        model.add_member(name, m["from"], m["to"], name, name)
        _, wanted = axes(s, m)
        x, y, z = model.members[name].T()[:3, :3]
        model.members[name].rotation = np.degrees(np.arctan2(-y @ wanted[2], z @ wanted[2]))
        assert np.abs(model.members[name].T()[:3, :3] - wanted).max() < 1e-13, f"{s['name']}: local axes of {name}"
        if "release" in m:
            end = {"from": "i", "to": "j"}[m["release"]["end"]]
            model.def_releases(name, **{f"R{m['release']['about']}{end}": True})
    for r in s["supports"]:
        model.def_support(r["node"], *r["held"])
    for c in s["load_cases"]:
        model.add_load_combo(c["name"], {c["name"]: 1.0})
        for load in c["node_loads"]:
            for direction, value in zip(LOADS, load["load"]):
                model.add_node_load(load["node"], direction, value, c["name"])
        for load in c["member_loads"]:
            for direction, value in zip(LOADS, load["force_per_length"]):
                model.add_member_dist_load(load["member"], direction, value, value, case=c["name"])
    model.analyze_linear(sparse=False)
    return [np.array([[getattr(model.nodes[n["name"]], dof)[c["name"]] for dof in DOFS] for n in s["nodes"]], float)
            for c in s["load_cases"]]


def assemble(s):
    """The same in plain numpy, by another way.

    The 12x12 stiffness of a member is had from the flexibility of its far end and from equilibrium; a hinge is an
    unknown more, the angle by which the member's end turns against its node.
    """
    index = {n["name"]: 6 * i for i, n in enumerate(s["nodes"])}
    hinges = [m["name"] for m in s["members"] if "release" in m]
    size = 6 * len(index) + len(hinges)
    stiffness = np.zeros((size, size))
    for m in s["members"]:
        length, r = axes(s, m)
        ea, gj, ey, ez = m["E"] * m["A"], m["G"] * m["J"], m["E"] * m["Iy"], m["E"] * m["Iz"]
        flexibility = np.diag([length / ea, length**3 / (3 * ez), length**3 / (3 * ey),
                               length / gj, length / ey, length / ez])
        flexibility[1, 5] = flexibility[5, 1] = length**2 / (2 * ez)
        flexibility[2, 4] = flexibility[4, 2] = -length**2 / (2 * ey)
        carried = np.eye(6)  # displacement of the far end when the near end moves and the member stays rigid
        carried[1, 5], carried[2, 4] = length, -length
        relative = np.hstack([-carried, np.eye(6)])  # of the far end: what the member's deformation is
        to_local = np.kron(np.eye(4), r)
        dofs = [*range(index[m["from"]], index[m["from"]] + 6), *range(index[m["to"]], index[m["to"]] + 6)]
        if "release" in m:
            at = {"from": 3, "to": 9}[m["release"]["end"]] + "xyz".index(m["release"]["about"])
            to_local = np.hstack([to_local, np.eye(12)[:, [at]]])
            dofs.append(6 * len(index) + hinges.index(m["name"]))
        b = relative @ to_local
        stiffness[np.ix_(dofs, dofs)] += b.T @ np.linalg.solve(flexibility, b)
    held = [index[r["node"]] + k for r in s["supports"] for k in range(6) if r["held"][k]]
    free = np.setdiff1d(np.arange(size), held)
    results = []
    for c in s["load_cases"]:
        load, u = np.zeros(size), np.zeros(size)
        for w in c["node_loads"]:
            load[index[w["node"]]:][:6] += w["load"]
        for w in c["member_loads"]:
            m = next(m for m in s["members"] if m["name"] == w["member"])
            assert "release" not in m
            length, r = axes(s, m)
            force = np.array(w["force_per_length"]) * length / 2
            moment = np.cross(r[0], force) * length / 6
            load[index[m["from"]]:][:6] += [*force, *moment]
            load[index[m["to"]]:][:6] += [*force, *-moment]
        u[free] = np.linalg.solve(stiffness[np.ix_(free, free)], load[free])
        results.append(u[:6 * len(index)].reshape(-1, 6))
    return results


# --------------------------------------------------------------------------------------------------------- checks

def difference(got, expected):
    """Largest relative difference, translations and rotations each against the largest of their kind."""
    return max(np.abs(g - e)[:, half].max() / np.abs(e[:, half]).max()
               for g, e in zip(got, expected) for half in (slice(0, 3), slice(3, 6)) if np.abs(e[:, half]).max() > 0)


def check_cantilevers():
    """PyNite against the textbook: six end loads and three uniform ones along local axes, members of all directions."""
    a, iy, iz, j = 3e-3, 2e-6, 5e-6, 4e-6
    e, g = STEEL["E"], STEEL["G"]
    worst = 0.0
    for tip in [(1.2, 0, 0), (0, 1.2, 0), (0, -1.2, 0), (0, 0, 1.2), (0, 0, -1.2), (0.5, -0.7, 0.9), (-0.4, 0.8, 0.3)]:
        for local_z in [(0.3, 0.5, 0.8), (-0.9, 0.2, 0.1)]:
            nodes, m = [node("a", 0, 0, 0), node("b", *tip)], member("a", "b", local_z, STEEL, a, iy, iz, j)
            s = structure("cantilever", "", nodes, [m], [support("a", CLAMPED)], [])
            length, r = axes(s, m)
            local = np.kron(np.eye(2), r)
            s["load_cases"] = [case(f"end{k}", [("b", 1e3 * local[k])]) for k in range(6)]
            s["load_cases"] += [case(f"uniform{k}", member_loads=[("a-b", 1e3 * r[k])]) for k in range(3)]
            expected = np.zeros((9, 6))
            expected[0, 0] = length / (e * a)
            expected[1, [1, 5]] = length**3 / (3 * e * iz), length**2 / (2 * e * iz)
            expected[2, [2, 4]] = length**3 / (3 * e * iy), -length**2 / (2 * e * iy)
            expected[3, 3] = length / (g * j)
            expected[4, [2, 4]] = -length**2 / (2 * e * iy), length / (e * iy)
            expected[5, [1, 5]] = length**2 / (2 * e * iz), length / (e * iz)
            expected[6, 0] = length**2 / (2 * e * a)
            expected[7, [1, 5]] = length**4 / (8 * e * iz), length**3 / (6 * e * iz)
            expected[8, [2, 4]] = length**4 / (8 * e * iy), -length**3 / (6 * e * iy)
            for u, x in zip(solve(s), 1e3 * expected):
                worst = max(worst, np.abs(local @ u[1] - x).max() / np.abs(x).max())
    assert worst < 1e-9, worst
    return worst


def exchanged(s):
    return {**s, "members": [{**m, "Iy": m["Iz"], "Iz": m["Iy"]} for m in s["members"]]}


def text(value, pad=""):
    """JSON in which whatever fits on a line stands on one."""
    line = json.dumps(value)
    if len(line) <= 200:
        return line
    inner = pad + "  "
    if isinstance(value, dict):
        ends, parts = "{}", [f"{json.dumps(k)}: {text(v, inner)}" for k, v in value.items()]
    else:
        ends, parts = "[]", [text(v, inner) for v in value]
    return ends[0] + "\n" + ",\n".join(inner + part for part in parts) + "\n" + pad + ends[1]


def main():
    version = Pynite.__version__
    print(f"PyNite {version}, numpy {np.__version__}")
    print(f"cantilevers against the textbook: {check_cantilevers():.1e}")
    structures = [portal(), ring(), box(False), arm(), box(True)]
    solutions = {}
    for s in structures:
        found = solutions[s["name"]] = solve(s)
        agreement, notices = difference(assemble(s), found), difference(solve(exchanged(s)), found)
        assert agreement < 1e-9, (s["name"], agreement)
        assert notices > 0.01, (s["name"], notices)
        print(f"{s['name']}: against the assembly {agreement:.1e}; Iy and Iz exchanged would change {notices:.0%}")
        for c, u in zip(s["load_cases"], found):
            c["displacements"] = [{"node": n["name"], "u": row.tolist()} for n, row in zip(s["nodes"], u)]
            largest = int(np.linalg.norm(u[:, :3], axis=1).argmax())
            print(f"  {c['name']}: {s['nodes'][largest]['name']} moves most, {u[largest]}")
    hinge = difference(solutions["box_hinged"], solutions["box"])
    assert hinge > 0.01, hinge
    print(f"the hinge changes the box's displacements by {hinge:.0%}")
    document = {
        "about": "Displacements of 3-D frames as PyNite computes them, written by make.py. SI units: m, N, Pa, rad.",
        "pynite_version": version,
        "conventions": {
            "vectors": "6-vectors are [translation; rotation] and [force; moment], global axes, z up",
            "local_axes": "x from node `from` to `to`; z = local_z less its part along x, normalised; y = z cross x",
            "sections": "Iz: bending in the local x-y plane (about z); Iy: in the x-z plane (about y); J: torsion",
            "beam": "Euler-Bernoulli, linear, without shear deformation",
            "held": "[x, y, z, rx, ry, rz], global; true is held at zero",
            "release": "where present: no moment about that local axis passes that end; `u` is the node's",
            "force_per_length": "N/m, global axes, uniform over the length of the member",
        },
        "structures": structures,
    }
    Path(__file__).with_name("frames.json").write_text(text(document) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

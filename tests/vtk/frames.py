# SPDX-License-Identifier: MIT
"""Reads the frames of `duet run --format vtu` and compares them with what the scenes say.

    python3 frames.py PROGRAM FOLDER own|vtk

Its own reader takes the files apart by Python's XML, offsets and lengths; or VTK reads them. Truth
is never of the files: bodies that nothing touches are at their centre plus time times velocity, a
body at rest is carried by its weight, and volumes have closed forms.
"""
import math
import os
import random
import shutil
import subprocess
import sys
import time
from signal import SIGINT, SIGKILL

sys.dont_write_bytecode = True
from vtu import read_own, read_series, vtk_of

POLYGON, QUAD, HEXAHEDRON, POLYHEDRON = 7, 9, 12, 42


# ---------------------------------------------------------------- files

def begin(program, folder, scene, steps):
    path = os.path.join(folder, "scene.lua")
    frames = os.path.join(folder, "frames")
    shutil.rmtree(frames, ignore_errors=True)
    with open(path, "w") as f:
        f.write(scene)
    return frames, subprocess.Popen([program, "run", path, "--steps", str(steps), "--frames", frames,
                                     "--format", "vtu", "--json"], stdout=subprocess.DEVNULL)


def run(program, folder, scene, steps):
    """The folder of the frames. The series name all files that there are."""
    frames, running = begin(program, folder, scene, steps)
    assert running.wait() == 0
    named = [path for name in ("bodies", "contacts", "ground") if os.path.exists(os.path.join(frames, name + ".pvd"))
             for _, path in read_series(frames, name)]
    there = [os.path.join(frames, f) for f in os.listdir(frames)
             if not f.endswith(".pvd") and f != "ground.vtp"]
    assert sorted(named) == sorted(there), there
    return frames


# ---------------------------------------------------------------- geometry

def turn(q, v):
    """v turned by the quaternion q = (x, y, z, w) of length 1, as q v q*."""
    def times(a, b):
        ax, ay, az, aw = a
        bx, by, bz, bw = b
        return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
                aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)
    x, y, z, w = q
    return times(times(q, (*v, 0)), (-x, -y, -z, w))[:3]


def size_of(half, radius, dims):
    """Volume of a rounded box; in 2D its area."""
    a, b, c = half
    if dims == 2:
        return 4 * a * b + 4 * (a + b) * radius + math.pi * radius ** 2
    return (8 * a * b * c + 8 * (a * b + b * c + c * a) * radius
            + 2 * math.pi * (a + b + c) * radius ** 2 + 4 / 3 * math.pi * radius ** 3)


def distance_to_core(point, half):
    return math.hypot(*(max(abs(p) - h, 0) for p, h in zip(point, half)))


def volume_of(faces, points):
    """By the divergence theorem: only right of faces that are closed and turned outwards."""
    volume = 0
    for face in faces:
        a = points[face[0]]
        for j, k in zip(face[1:], face[2:]):
            b, c = points[j], points[k]
            volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                       + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
    return volume


def near(a, b, tolerance):
    return all(abs(x - y) <= tolerance for x, y in zip(a, b))


# ---------------------------------------------------------------- bodies that drift

def make_bodies(dims, random):
    """Boxes, and every shape that a radius makes of one, each with a rotation and a velocity."""
    bodies = []
    for i in range(40):
        kind = i % 16
        half = [0.2 + random.random() if kind >> k & 1 and k < dims else 0 for k in range(3)]
        radius = 0.1 + random.random() if kind >= 8 else 0
        q = [random.gauss(0, 1) if dims == 3 or k >= 2 else 0 for k in range(4)]
        length = math.hypot(*q)
        centre = [10 * (i % 5), 10 * (i // 5), -5 if dims == 3 else 0]
        velocity = [random.uniform(-2, 2) if k < dims else 0 for k in range(3)]
        bodies.append((centre, half, radius, [x / length for x in q], velocity))
    return bodies


def scene_of(bodies, dims):
    def row(v):
        return "{ %s }" % ", ".join("%.9g" % x for x in v)
    lines = ["add { centre = %s, half_extents = %s, radius = %.9g, %s, velocity = %s }" % (
        row(c[:dims]), row(h[:dims]), r,
        "rotation = " + row(q) if dims == 3 else "angle = %.9g" % (2 * math.atan2(q[2], q[3])),
        row(v[:dims])) for c, h, r, q, v in bodies]
    return "\n".join(lines) + "\nreturn { dims = %d }\n" % dims


def check_box(points, centre, half, q, dims):
    signs = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    sides = [(x, y, z) for z in ((-1, 1) if dims == 3 else (0,)) for x, y in signs]
    assert len(points) == len(sides)
    for point, side in zip(points, sides):
        corner = turn(q, [s * h for s, h in zip(side, half)])
        assert near(point, [c + d for c, d in zip(centre, corner)], 1e-4), (point, centre, side)


def check_rounded(points, centre, half, radius, q, dims):
    back = [-q[0], -q[1], -q[2], q[3]]
    for point in points:
        local = turn(back, [p - c for p, c in zip(point, centre)])
        assert abs(distance_to_core(local, half) - radius) < 1e-4, local


def check_closed(faces):
    edges = [(a, b) for f in faces for a, b in zip(f, f[1:] + f[:1])]
    assert len(set(edges)) == len(edges), "a face is there twice, or turned inwards"
    assert all((b, a) in set(edges) for a, b in edges), "a hole"


def faces_of(grid, cell):
    end = grid["faceoffsets"][cell]
    start = max([0] + [e for e in grid["faceoffsets"][:cell] if e >= 0])
    words = grid["faces"][start:end]
    faces, at = [], 1
    for _ in range(words[0]):
        faces.append(words[at + 1:at + 1 + words[at]])
        at += 1 + words[at]
    assert at == len(words)
    return faces


def check_drift(grid, bodies, dims):
    n = len(bodies)
    assert grid["counts"] == {"NumberOfPoints": len(grid["points"]), "NumberOfCells": n}
    assert grid["id"] == list(range(n)) and not any(grid["asleep"])
    assert grid["labels"]["orientation"] == ["w", "x", "y", "z"]
    for i, (centre, half, radius, q, velocity) in enumerate(bodies):
        centre = [c + grid["time"] * v for c, v in zip(centre, velocity)]
        first = grid["offsets"][i - 1] if i > 0 else 0
        cell = grid["connectivity"][first:grid["offsets"][i]]
        points = [grid["points"][p] for p in cell]
        sign = 1 if sum(a * b for a, b in zip(grid["orientation"][i][1:], q)) >= 0 else -1
        assert near(grid["velocity"][i], velocity, 1e-6)
        assert near(grid["half_extents"][i], half, 1e-6) and abs(grid["radius"][i] - radius) < 1e-6
        assert near(grid["orientation"][i], [sign * x for x in (q[3], *q[:3])], 1e-5)
        if radius == 0:
            assert grid["types"][i] == (HEXAHEDRON if dims == 3 else QUAD)
            check_box(points, centre, half, q, dims)
            continue
        assert grid["types"][i] == (POLYHEDRON if dims == 3 else POLYGON)
        check_rounded(points, centre, half, radius, q, dims)
        faces = faces_of(grid, i) if dims == 3 else []
        if dims == 3:
            assert sorted(set(sum(faces, []))) == list(cell)
            check_closed(faces)
            size = volume_of(faces, grid["points"])
        else:
            size = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(points, points[1:] + points[:1])) / 2
        whole = size_of(half, radius, dims)
        assert 0.85 * whole < size < whole * 1.00001, (size, whole)


def check_drift_vtk(path, bodies, dims, time):
    grid, sizes = read_vtk(path), None
    assert grid.GetNumberOfCells() == len(bodies)
    assert abs(grid.GetFieldData().GetArray("TimeValue").GetValue(0) - time) < 1e-12
    measure = vtk.vtkCellSizeFilter()
    measure.SetInputData(grid)
    measure.Update()
    sizes = measure.GetOutput().GetCellData().GetArray("Volume" if dims == 3 else "Area")
    for i, (centre, half, radius, q, velocity) in enumerate(bodies):
        centre = [c + time * v for c, v in zip(centre, velocity)]
        b = grid.GetCell(i).GetBounds()
        assert near([(b[2 * k] + b[2 * k + 1]) / 2 for k in range(3)], centre, 1e-4)
        assert near(grid.GetCellData().GetArray("velocity").GetTuple(i), velocity, 1e-6)
        assert grid.GetCellData().GetArray("id").GetValue(i) == i
        axes = [turn(q, [h if k == j else 0 for j in range(3)]) for k, h in enumerate(half)]
        for k in range(dims):
            wide = 2 * (sum(abs(a[k]) for a in axes) + radius)
            seen = b[2 * k + 1] - b[2 * k]
            assert seen <= wide + 1e-4 and seen >= wide - 0.3 * radius - 1e-4, (seen, wide)
        whole = size_of(half, radius, dims)
        assert whole * (0.85 if radius else 0.9999) - 1e-5 <= sizes.GetValue(i) <= whole * 1.0001 + 1e-5


def test_drift(program, folder, dims, seed):
    bodies = make_bodies(dims, random.Random(seed))
    frames = run(program, folder, scene_of(bodies, dims), 12)
    series = read_series(frames, "bodies")
    assert near([t for t, _ in series], [k / 30 for k in range(7)], 1e-9) and len(series) == 7
    assert not os.path.exists(os.path.join(frames, "contacts.pvd")), "nothing here can touch"
    for time, path in series:
        if vtk:
            check_drift_vtk(path, bodies, dims, time)
        else:
            grid = read_own(path)
            assert abs(grid["time"] - time) < 1e-12
            check_drift(grid, bodies, dims)


# ---------------------------------------------------------------- bodies at rest

REST = """
add { centre = { 0, 0, -1 }, half_extents = { 4, 4, 1 }, mass = 0 }
add { centre = { -2, 0, 0.5 }, half_extents = { 0.5, 0.5, 0.5 }, mass = 3 }
add { centre = { 2, 0, 0.5 }, half_extents = { 0, 0, 0 }, radius = 0.5, mass = 5 }
add { centre = { 7, 0, -1.5 }, half_extents = { 0.5, 0.5, 0.5 }, mass = 2 } -- on the wall below
return { dims = 3, gravity = { 0, 0, -10 }, boundary = 'walls', wants = { 'contact_response', 'sleep' },
         world = { lower = { -9, -9, -2 }, upper = { 9, 9, 9 } } }
"""


def check_rest(contacts, asleep):
    """The floor, which is body 0, or the wall carries each body's weight."""
    carried = {1: 0, 2: 0, 3: 0}
    for a, b, force, normal, at in contacts:
        body = a if a in carried and b <= 0 else b
        upwards = 1 if body == b else -1  # force is on b
        carried[body] += upwards * force[2]
        below = -2 if body == 3 else 0
        assert abs(at[2] - below) < 0.02 and abs(abs(normal[2]) - 1) < 1e-3
        assert {a, b} == ({3, -5} if body == 3 else {0, body}), (a, b)
    for body, mass in ((1, 3), (2, 5), (3, 2)):
        assert abs(carried[body] - 10 * mass) < 0.2 * mass, carried
    assert asleep[0] == 0


def test_rest(program, folder):
    frames = run(program, folder, REST, 120)
    bodies, contacts = read_series(frames, "bodies"), read_series(frames, "contacts")
    assert [t for t, _ in bodies] == [t for t, _ in contacts]
    assert read_rows(contacts[0][1], ["points"]) == [], "nothing touched before the first step"
    slept = []
    for (_, body), (_, contact) in list(zip(bodies, contacts))[6:]:
        asleep = [a for a, in read_rows(body, ["asleep"])]
        check_rest(read_rows(contact, ["a", "b", "force", "normal", "points"]), asleep)
        slept.append(sum(asleep))
    assert slept[0] == 0 and slept[-1] == 3, slept


# ---------------------------------------------------------------- a ground

GROUND = """
add { centre = { 1, 0, 1 }, half_extents = { 0.5, 0.5, 0.5 }, mass = 3 }
return { dims = 3, gravity = { 0, 0, -10 }, wants = { 'contact_response' },
         heights = { nx = 3, ny = 4, spacing = { 2, 1.5 }, origin = { -1, -3, 0.25 },
                     values = { 0, 0, 0.25, 0, 0.25, 0, 0.25, 0, 0, 0.5, 0, 0.25 } } }
"""
VALUES = [0, 0, 0.25, 0, 0.25, 0, 0.25, 0, 0, 0.5, 0, 0.25]


def height_at(x, y):
    """Of the ground: a cell's triangles meet in the line from its lowest corner to the opposite one."""
    i, j = min(int((x + 1) / 2), 1), min(int((y + 3) / 1.5), 2)
    u, v = (x + 1) / 2 - i, (y + 3) / 1.5 - j
    a, b, c, d = (0.25 + VALUES[3 * (j + m) + i + k] for m in (0, 1) for k in (0, 1))
    return a + u * (b - a) + v * (d - b) if u >= v else a + v * (c - a) + u * (d - c)


def strips_of(path):
    if vtk:
        ground = read_vtk(path)
        ids = vtk.vtkIdList()
        strips = []
        ground.GetStrips().InitTraversal()
        while ground.GetStrips().GetNextCell(ids):
            strips.append([ids.GetId(k) for k in range(ids.GetNumberOfIds())])
        return [ground.GetPoint(k) for k in range(ground.GetNumberOfPoints())], strips
    ground = read_own(path)
    assert ground["counts"] == {"NumberOfPoints": 12, "NumberOfStrips": 3}
    ends = [0] + ground["offsets"]
    return ground["points"], [ground["connectivity"][a:b] for a, b in zip(ends, ends[1:])]


def test_ground(program, folder):
    """The triangles cover the grid once, look upwards, and lie on the ground."""
    frames = run(program, folder, GROUND, 8)
    points, strips = strips_of(os.path.join(frames, "ground.vtp"))
    area = 0
    for strip in strips:
        for k in range(len(strip) - 2):
            corners = [points[p] for p in (strip[k:k + 3] if k % 2 == 0 else
                                           (strip[k + 1], strip[k], strip[k + 2]))]
            a, b, c = corners
            upwards = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            assert upwards > 0, corners
            area += upwards / 2
            for weights in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 0.3, 0.2), (0.1, 0.2, 0.7)):
                x, y, z = (sum(w * p[k] for w, p in zip(weights, corners)) for k in range(3))
                assert abs(z - height_at(x, y)) < 1e-12, (x, y, z)
    assert abs(area - 4 * 4.5) < 1e-12, area


MESH = """
add { centre = { 0, 0, 4 }, half_extents = { 0.5, 0.5, 0.5 } }
return { dims = 3, gravity = { 0, 0, -10 }, wants = { 'contact_response' },
         mesh = { file = 'block.obj', scale = 0.5, origin = { 0.25, 0, 1 } } }
"""
BLOCK = [(x, y, z) for z in (-2, 2) for y in (-3, 3) for x in (-1, 1)]
FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def triangles_of(path):
    if vtk:
        mesh = read_vtk(path)
        ids, triangles = vtk.vtkIdList(), []
        mesh.GetPolys().InitTraversal()
        while mesh.GetPolys().GetNextCell(ids):
            triangles.append([ids.GetId(k) for k in range(ids.GetNumberOfIds())])
        return [mesh.GetPoint(k) for k in range(mesh.GetNumberOfPoints())], triangles
    mesh = read_own(path)
    assert mesh["counts"] == {"NumberOfPoints": 8, "NumberOfPolys": 12}
    ends = [0] + mesh["offsets"]
    return mesh["points"], [mesh["connectivity"][a:b] for a, b in zip(ends, ends[1:])]


def test_mesh(program, folder):
    """A block of triangles is closed and turned outwards, of its size and where it belongs."""
    with open(os.path.join(folder, "block.obj"), "w") as f:
        f.writelines("v %g %g %g\n" % v for v in BLOCK)
        f.writelines("f %d %d %d %d\n" % tuple(i + 1 for i in face) for face in FACES)
    points, triangles = triangles_of(os.path.join(run(program, folder, MESH, 8), "ground.vtp"))
    assert all(len(t) == 3 for t in triangles)
    assert abs(volume_of(triangles, points) - 1 * 3 * 2) < 1e-12
    for v, p in zip(BLOCK, points):
        assert near(p, (0.25 + v[0] / 2, v[1] / 2, 1 + v[2] / 2), 0), (v, p)


CARRIED = """
add { centre = { 1, 0, 0 }, half_extents = { 0, 0, 0 }, mass = 0, group = 0, mask = 0,
      velocity = { 0.5, 0, 0 }, angular_velocity = { 0, 0, 0.75 } }
add { centre = { 0, 0, 9 }, half_extents = { 0.5, 0.5, 0.5 } }
return { dims = 3, gravity = { 0, 0, -10 }, wants = { 'contact_response' },
         mesh = { file = 'block.obj', scale = 0.5, origin = { 0.25, 0, 1 }, carrier = 0 } }
"""


def test_carried(program, folder):
    """A mesh that a body carries is where that is, in each frame."""
    frames = run(program, folder, CARRIED, 60)
    for time, path in read_series(frames, "ground"):
        points, triangles = triangles_of(path)
        assert abs(volume_of(triangles, points) - 1 * 3 * 2) < 1e-4
        c, s = math.cos(0.75 * time), math.sin(0.75 * time)
        for v, p in zip(BLOCK, points):
            x, y = 0.25 + v[0] / 2, v[1] / 2
            place = (1 + 0.5 * time + c * x - s * y, s * x + c * y, 1 + v[2] / 2)
            assert near(p, place, 1e-4), (time, v, p)


# ---------------------------------------------------------------- a run that ends in the middle

def test_end(program, folder, signal, status):
    """However it ends, what the series name is there and whole; Ctrl-C leaves nothing half-written."""
    frames, running = begin(program, folder, REST, 10 ** 9)
    while not (os.path.exists(os.path.join(frames, "contacts.pvd"))
               and len(read_series(frames, "contacts")) >= 5):
        assert running.poll() is None
        time.sleep(0.01)
    running.send_signal(signal)
    assert running.wait() == status
    for name in ("bodies", "contacts"):
        for at, path in read_series(frames, name):
            assert abs(read_own(path)["time"] - at) < 1e-12
    assert signal == SIGKILL or not [f for f in os.listdir(frames) if f.endswith(".part")]


def read_rows(path, names):
    """Some arrays of a file, row by row."""
    if not vtk:
        found = read_own(path)
        return list(zip(*(found[n] for n in names)))
    data = read_vtk(path)
    def column(name):
        if name == "points":
            return [data.GetPoint(i) for i in range(data.GetNumberOfPoints())]
        a = data.GetPointData().GetArray(name) or data.GetCellData().GetArray(name)
        rows = [a.GetTuple(i) for i in range(a.GetNumberOfTuples())]
        return [r[0] for r in rows] if a.GetNumberOfComponents() == 1 else rows
    return list(zip(*map(column, names)))


def read_vtk(path):
    reader = vtk.vtkXMLUnstructuredGridReader() if path.endswith("vtu") else vtk.vtkXMLPolyDataReader()
    errors = []
    reader.AddObserver("ErrorEvent", lambda *_: errors.append(path))
    reader.SetFileName(path)
    reader.Update()
    assert not errors, "VTK cannot read " + path
    return reader.GetOutput()


vtk = vtk_of(sys.argv[3])
seed = int(os.environ.get("DUET_TEST_SEED", 0)) or random.randrange(1, 2 ** 31)
print("DUET_TEST_SEED=%d" % seed)
os.makedirs(sys.argv[2], exist_ok=True)
for dims in (2, 3):
    test_drift(sys.argv[1], sys.argv[2], dims, seed)
test_rest(sys.argv[1], sys.argv[2])
test_ground(sys.argv[1], sys.argv[2])
test_mesh(sys.argv[1], sys.argv[2])
test_carried(sys.argv[1], sys.argv[2])
if not vtk:
    test_end(sys.argv[1], sys.argv[2], SIGKILL, -SIGKILL)
    test_end(sys.argv[1], sys.argv[2], SIGINT, -SIGINT)

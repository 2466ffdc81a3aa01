# SPDX-License-Identifier: MIT
"""Compares the frames of `duet cluster --frames` with those of `duet run`, of the same scene.

    python3 cluster_frames.py PROGRAM FOLDER own|vtk

At any number of ranks and parts the pieces of a frame together have the bodies of one motion, each
once and with the same bits; which piece has it is left to the borders.
"""
import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree as xml

sys.dont_write_bytecode = True
from vtu import read_own, read_series, vtk_of

NAMES = ["id", "velocity", "angular_velocity", "asleep", "half_extents", "radius", "orientation"]


def run(command, frames):
    shutil.rmtree(frames, ignore_errors=True)
    told = subprocess.run(command + ["--frames", frames, "--format", "vtu", "--json"],
                          stdout=subprocess.PIPE, check=True)
    assert told.stdout
    return frames


def rows_by_id(grid):
    """Each body's cell: its data and its corners."""
    rows, first = {}, 0
    for i, end in enumerate(grid["offsets"]):
        points = [tuple(grid["points"][p]) for p in grid["connectivity"][first:end]]
        assert grid["id"][i] not in rows, "a body is there twice"
        rows[grid["id"][i]] = [grid[name][i] for name in NAMES] + [points]
        first = end
    return rows


def pieces_of(path):
    """Paths of the pieces, and the arrays that the file says they have."""
    root = xml.parse(path).getroot()
    assert root.get("type") == "PUnstructuredGrid"
    named = [a.get("Name") for a in root[0].find("PCellData")]
    assert named == NAMES, named
    assert [a.get("NumberOfComponents") for a in root[0].find("PPoints")] == ["3"]
    time = float(root[0].find("FieldData")[0].text)
    return time, [os.path.join(os.path.dirname(path), p.get("Source")) for p in root[0].iter("Piece")]


def check_frame(path, time, expected, n_pieces):
    told, pieces = pieces_of(path)
    assert abs(told - time) < 1e-12 and len(pieces) == n_pieces
    rows = {}
    for piece in pieces:
        grid = read_own(piece)
        assert abs(grid["time"] - time) < 1e-12
        here = rows_by_id(grid)
        assert not rows.keys() & here.keys(), "a body is in two pieces"
        rows.update(here)
    assert rows == expected, path


def check_vtk(path, expected):
    """VTK puts the pieces together itself."""
    reader = vtk.vtkXMLPUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    ids = [grid.GetCellData().GetArray("id").GetValue(i) for i in range(grid.GetNumberOfCells())]
    assert sorted(ids) == sorted(expected)
    for i, body in enumerate(ids):
        velocity = grid.GetCellData().GetArray("velocity").GetTuple(i)
        assert tuple(velocity) == tuple(expected[body][1]), body


def compare(program, folder, scene, ranks, parts):
    one = run([program, "run", *scene], os.path.join(folder, "one"))
    many = run([program, "cluster", *scene, "--ranks", str(ranks), "--parts", str(parts)],
               os.path.join(folder, "many"))
    expected, found = read_series(one, "bodies"), read_series(many, "bodies")
    assert [t for t, _ in expected] == [t for t, _ in found] and len(found) > 3
    assert os.path.exists(os.path.join(one, "ground.vtp")) == os.path.exists(
        os.path.join(many, "ground.vtp"))
    for (time, path), (_, other) in zip(expected, found):
        rows = rows_by_id(read_own(path))
        if vtk:
            check_vtk(other, rows)
        else:
            check_frame(other, time, rows, ranks * parts)
    there = [f for f in os.listdir(many) if f.endswith(".vtu")]
    assert len(there) == len(found) * ranks * parts, there


vtk = vtk_of(sys.argv[3])
os.makedirs(sys.argv[2], exist_ok=True)
compare(sys.argv[1], sys.argv[2], ["falling", "-n", "150", "--steps", "20"], 3, 1)
compare(sys.argv[1], sys.argv[2], ["marbles", "-n", "40", "--steps", "12"], 2, 2)
compare(sys.argv[1], sys.argv[2], ["terrain", "-n", "60", "--steps", "8"], 1, 3)

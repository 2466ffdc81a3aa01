# SPDX-License-Identifier: MIT
"""A reader of the files of frames that needs nothing but Python."""
import os
import struct
import sys
import xml.etree.ElementTree as xml

TYPES = {"Float32": "f", "Float64": "d", "Int64": "q", "UInt8": "B"}


def read_own(path):
    """The arrays of a file by name, each a list of rows or of numbers, and its counts."""
    data = open(path, "rb").read()
    at = data.index(b"<AppendedData")
    start = data.index(b"_", at) + 1
    root = xml.fromstring(data[:at] + b"</VTKFile>")
    assert root.get("byte_order") == "LittleEndian" and root.get("header_type") == "UInt64"
    piece = root[0].find("Piece")
    found = {"counts": {k: int(v) for k, v in piece.attrib.items()}, "labels": {}}
    found["time"] = float(root[0].find("FieldData")[0].text)
    end = 0
    for section in piece:
        for a in section:
            assert int(a.get("offset")) == end, "arrays follow each other"
            (size,) = struct.unpack_from("<Q", data, start + end)
            letter, width = TYPES[a.get("type")], int(a.get("NumberOfComponents"))
            n = size // struct.calcsize("<" + letter)
            values = struct.unpack_from("<%d%s" % (n, letter), data, start + end + 8)
            rows = [values[i:i + width] for i in range(0, n, width)] if width > 1 else list(values)
            found[a.get("Name")] = rows
            found["labels"][a.get("Name")] = [a.get("ComponentName%d" % k) for k in range(width)]
            end += 8 + size
    assert data[start + end:].split() == [b"</AppendedData>", b"</VTKFile>"]
    return found


def read_series(folder, name):
    """Times and paths of a .pvd."""
    entries = xml.parse(os.path.join(folder, name + ".pvd")).getroot()[0]
    return [(float(e.get("timestep")), os.path.join(folder, e.get("file"))) for e in entries]


def vtk_of(reader):
    """VTK if it is to read the files, else None; the test is skipped if there is none."""
    if reader != "vtk":
        return None
    try:
        import vtk
    except ImportError:
        print("no VTK here")
        sys.exit(0)
    print("VTK", vtk.vtkVersion().GetVTKVersion())
    return vtk

# SPDX-License-Identifier: MIT
"""Draws one frame of `duet run --frames DIR --format vtu` with VTK: on the left the bodies, coloured by
their speed, on the right an arrow for the force at each point where two touch.

    python3 paraview.py DIR NUMBER PICTURE.png
"""
import sys

import vtk

folder, number, picture = sys.argv[1:]


def read(reader, name):
    reader.SetFileName("%s/%s_%05d.%s" % (folder, name, int(number), "vtu" if name == "bodies" else "vtp"))
    reader.Update()
    return reader


def actor_of(source):
    mapper = vtk.vtkDataSetMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    return actor


def coloured(actor, red, green, blue, opacity):
    actor.GetProperty().SetColor(red, green, blue)
    actor.GetProperty().SetOpacity(opacity)
    return actor


def by_speed(actor):
    speeds = vtk.vtkColorTransferFunction()
    speeds.AddRGBPoint(0, 0.25, 0.35, 0.55)
    speeds.AddRGBPoint(2, 0.45, 0.70, 0.55)
    speeds.AddRGBPoint(4, 0.95, 0.75, 0.35)
    speeds.SetVectorModeToMagnitude()
    mapper = actor.GetMapper()
    mapper.ScalarVisibilityOn()
    mapper.SetLookupTable(speeds)
    mapper.SetUseLookupTableScalarRange(True)
    mapper.SetScalarModeToUseCellFieldData()
    mapper.SelectColorArray("velocity")
    return actor


bodies = read(vtk.vtkXMLUnstructuredGridReader(), "bodies")
contacts = read(vtk.vtkXMLPolyDataReader(), "contacts")
contacts.GetOutput().GetPointData().SetActiveVectors("force")
arrow = vtk.vtkArrowSource()
arrows = vtk.vtkGlyph3D()
arrows.SetInputConnection(contacts.GetOutputPort())
arrows.SetSourceConnection(arrow.GetOutputPort())
arrows.SetScaleModeToScaleByVector()
arrows.SetScaleFactor(0.01)

camera = vtk.vtkCamera()
camera.SetViewUp(0, 0, 1)
camera.SetPosition(1, -2, 0.8)
window = vtk.vtkRenderWindow()
window.SetOffScreenRendering(True)
window.SetAlphaBitPlanes(True)
window.SetMultiSamples(0)
window.SetSize(920, 400)


def show(left, right, *actors):
    renderer = vtk.vtkRenderer()
    renderer.SetViewport(left, 0, right, 1)
    renderer.SetBackground(1, 1, 1)
    renderer.SetUseDepthPeeling(True)
    renderer.SetActiveCamera(camera)
    for actor in actors:
        renderer.AddActor(actor)
    window.AddRenderer(renderer)
    return renderer


first = show(0, 0.5, by_speed(actor_of(bodies)))
show(0.5, 1, coloured(actor_of(bodies), 0.4, 0.5, 0.6, 0.12), coloured(actor_of(arrows), 0.8, 0.1, 0.15, 1))
first.ResetCamera()
camera.Zoom(1.3)
window.Render()

image = vtk.vtkWindowToImageFilter()
image.SetInput(window)
writer = vtk.vtkPNGWriter()
writer.SetFileName(picture)
writer.SetInputConnection(image.GetOutputPort())
writer.Write()

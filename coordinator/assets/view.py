"""Shows the snapshots of a run in ParaView, particles at their size.

    paraview --script=snapshots/view.py
    pvpython snapshots/view.py picture.png     # saves the last time as a picture
"""

import os
import sys

from paraview.simple import (
    ColorBy,
    CreateView,
    GetActiveView,
    GetAnimationScene,
    GetColorTransferFunction,
    GetScalarBar,
    PVDReader,
    Render,
    ResetCamera,
    SaveScreenshot,
    Show,
)

# What is coloured by which array; walls are grey.
SIDES = {"walls": None, "fluid": "pressure", "solid": "von_mises"}


def folder():
    """Folder of this script, however ParaView runs it."""
    path = globals().get("__file__")
    return os.path.dirname(os.path.abspath(path)) if path else os.getcwd()


def show(side, array, view):
    """Shows one side of the run as disks or spheres."""
    path = os.path.join(folder(), side + ".pvd")
    if not os.path.isfile(path):
        return None
    reader = PVDReader(registrationName=side, FileName=path)
    reader.UpdatePipeline()
    display = Show(reader, view)
    display.SetRepresentationType("Point Gaussian")
    bounds = reader.GetDataInformation().GetBounds()
    display.ShaderPreset = "Plain circle" if bounds[4] == bounds[5] else "Sphere"
    # The array holds radii in metres.
    display.GaussianRadius = 1.0
    display.ScaleByArray = 1
    display.SetScaleArray = ["POINTS", "point_radius"]
    display.UseScaleFunction = 0
    if array is None:
        display.ColorArrayName = [None, ""]
        display.AmbientColor = display.DiffuseColor = [0.55, 0.55, 0.55]
    else:
        ColorBy(display, ("POINTS", array))
        display.RescaleTransferFunctionToDataRange(False, True)
        bar = GetScalarBar(GetColorTransferFunction(array), view)
        bar.Title = side + ": " + array + " [Pa]"
        bar.ComponentTitle = ""
        bar.TitleFontSize = bar.LabelFontSize = 14
        display.SetScalarBarVisibility(view, True)
    return reader


def main():
    view = GetActiveView() or CreateView("RenderView")
    scene = GetAnimationScene()
    readers = {side: show(side, array, view) for side, array in SIDES.items()}
    scene.UpdateAnimationUsingDataTimeSteps()
    scene.GoToLast()
    for side, array in SIDES.items():
        if readers[side] is not None and array is not None:
            Show(readers[side], view).RescaleTransferFunctionToDataRange(False, True)
    bounds = [reader.GetDataInformation().GetBounds() for reader in readers.values() if reader is not None]
    flat = all(b[4] == b[5] for b in bounds)
    view.InteractionMode = "2D" if flat else "3D"
    view.OrientationAxesVisibility = 0 if flat else 1
    if not flat:
        view.CameraPosition = [1.0, -2.0, 1.0]
        view.CameraFocalPoint = [0.0, 0.0, 0.0]
        view.CameraViewUp = [0.0, 0.0, 1.0]
    picture = sys.argv[1] if len(sys.argv) > 1 and sys.argv[1].endswith(".png") else None
    if picture is not None:
        view.ViewSize = [1200, 800]
    ResetCamera(view)
    Render(view)
    if picture is not None:
        SaveScreenshot(picture, view, ImageResolution=[1200, 800])


main()

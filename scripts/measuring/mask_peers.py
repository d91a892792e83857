"""VTK's surfaces of a mask. Run by Python with NumPy, and VTK of version 9.3 or later for its surface nets:

    mask_peers.py MASK.npy WAY RUNS OUT.ply   writes the mesh; milliseconds of each run, by the clock
                                              and of processors, and the version as JSON

Each run is a process of its own, so all are cold. Before, it makes the surface of a few voxels, which loads libraries and
starts threads.
"""

import json
import os
import struct
import sys
import time

import numpy as np
from vtkmodules.util import numpy_support
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkWindowedSincPolyDataFilter
from vtkmodules.vtkFiltersGeneral import vtkDiscreteFlyingEdges3D

import label_maps


def nets(image, rounds):
    """Returns the surface nets; `rounds` of smoothing, or VTK's default number."""
    from vtkmodules.vtkFiltersCore import vtkSurfaceNets3D

    net = vtkSurfaceNets3D()
    net.SetInputData(image)
    net.SetValue(0, 1)
    net.SetOutputMeshTypeToTriangles()
    net.SetSmoothing(rounds != 0)
    if rounds:
        net.SetNumberOfIterations(rounds)
    net.Update()
    return net.GetOutput()


def edges(image, band):
    """Returns the surface of flying edges; with a pass band, smoothed by a windowed sinc filter as 3D Slicer sets it."""
    surface = vtkDiscreteFlyingEdges3D()
    surface.SetInputData(image)
    surface.SetValue(0, 1)
    surface.ComputeNormalsOff()
    surface.ComputeGradientsOff()
    surface.Update()
    if band is None:
        return surface.GetOutput()
    smooth = vtkWindowedSincPolyDataFilter()
    smooth.SetInputData(surface.GetOutput())
    smooth.SetNumberOfIterations(20)
    smooth.SetPassBand(band)
    smooth.NormalizeCoordinatesOn()
    smooth.BoundarySmoothingOff()
    smooth.FeatureEdgeSmoothingOff()
    smooth.NonManifoldSmoothingOn()
    smooth.Update()
    return smooth.GetOutput()


WAYS = {
    "nets-0": lambda image: nets(image, 0),
    "nets": lambda image: nets(image, None),
    "nets-100": lambda image: nets(image, 100),
    "edges": lambda image: edges(image, None),
    "edges-sinc-0.1": lambda image: edges(image, 0.1),
    "edges-sinc-0.01": lambda image: edges(image, 0.01),
}


SMALL = np.pad(np.ones((4, 4, 4), np.uint8), 2)


def image_of(mask):
    image = vtkImageData()
    image.SetDimensions(*mask.shape[::-1])
    image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(mask.ravel()))
    return image


def write(surface, path):
    points = numpy_support.vtk_to_numpy(surface.GetPoints().GetData())
    label_maps.write_ply(path, points, numpy_support.vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3))


def timed(image, way, path):
    """Returns the milliseconds of a run in a process of its own, by the clock and of processors; it writes its mesh."""
    readable, writable = os.pipe()
    child = os.fork()
    if child == 0:
        WAYS[way](image_of(SMALL))
        begin, used = time.perf_counter(), time.process_time()
        surface = WAYS[way](image)
        os.write(writable, struct.pack("2d", 1000 * (time.perf_counter() - begin), 1000 * (time.process_time() - used)))
        if path:
            write(surface, path)
        os._exit(0)
    os.close(writable)
    with os.fdopen(readable, "rb") as pipe:
        milliseconds = pipe.read()
    if os.waitpid(child, 0)[1] != 0:
        sys.exit(f"mask_peers: {way} failed")
    return struct.unpack("2d", milliseconds)


def main(mask, way, runs, path):
    image = image_of(np.load(mask))
    wall, cpu = zip(*(timed(image, way, path if run == 0 else None) for run in range(int(runs))))
    print(json.dumps({"ms": wall, "cpu_ms": cpu, "vtk": vtkVersion.GetVTKVersion()}))


if __name__ == "__main__":
    main(*sys.argv[1:])

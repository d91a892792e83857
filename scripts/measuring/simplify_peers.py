"""Inputs for the measurement of simplification, and its peers of VTK. Run by Python with NumPy, and VTK:

    simplify_peers.py box SIDE FILE.npy                   the distance to a cube whose sides lie on planes of samples
    simplify_peers.py vtk FILTER TRIANGLES IN.ply OUT.ply  simplifies to that many; its seconds as JSON
"""

import json
import sys
import time

import numpy as np


def box(side):
    """Distances to the surface, above 0 inside; exact within 3 voxels, and clamped beyond."""
    margin = 10
    beyond = [np.abs(np.arange(side + 2 * margin + 1, dtype=np.float32) - (side / 2 + margin)) - side / 2] * 3
    z, y, x = np.meshgrid(*beyond, indexing="ij", sparse=True)
    outside = np.sqrt(sum(np.maximum(axis, 0) ** 2 for axis in (x, y, z)))
    inside = np.minimum(np.maximum(np.maximum(x, y), z), 0)
    return np.clip(-(outside + inside), -3, 3).astype(np.float32)


def by_vtk(name, wanted, source, target):
    import vtk

    reader = vtk.vtkPLYReader()
    reader.SetFileName(source)
    reader.Update()
    mesh = reader.GetOutput()
    reduction = 1 - wanted / mesh.GetNumberOfPolys()
    simplify = getattr(vtk, name)()
    simplify.SetTargetReduction(reduction)
    if name == "vtkDecimatePro":
        simplify.PreserveTopologyOn()
    simplify.SetInputData(mesh)
    begin = time.perf_counter()
    simplify.Update()
    seconds = time.perf_counter() - begin
    writer = vtk.vtkPLYWriter()
    writer.SetInputData(simplify.GetOutput())
    writer.SetFileName(target)
    writer.Write()
    return {"vtk": vtk.vtkVersion().GetVTKVersion(), "seconds": seconds}


def main(what, *arguments):
    if what == "box":
        np.save(arguments[1], box(int(arguments[0])))
    else:
        print(json.dumps(by_vtk(arguments[0], int(arguments[1]), *arguments[2:])))


if __name__ == "__main__":
    main(*sys.argv[1:])

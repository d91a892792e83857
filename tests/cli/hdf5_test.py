"""HDF5 files, read by the plug-in around its library: datasets, VTKHDF, Imaris, BigDataViewer, ITK."""

import json
import sys

from support import SOURCE, main

sys.path.insert(0, str(SOURCE / "tests" / "support"))

from written_volumes import WrittenVolumes, needs_reader  # noqa: E402

ARRAYS = """import h5py, numpy as np
a = np.random.default_rng(1).random((6, 7, 8), dtype=np.float32)
def save(name, values, **more):
    np.save(name + '.npy', np.asarray(values).astype('f8')); return f.create_dataset(name, data=values, **more)
with h5py.File('a.h5', 'w') as f:
    for t in ('u1', 'i1', 'u2', '>i2', 'u4', 'i4', 'i8', '>u8', 'f2', '>f4', 'f8'): save(t.replace('>', 'be'), (a * 100).astype(t))
    save('bool', a > 0.5)
    f['compound'] = np.zeros((3, 3, 3), dtype=[('a', 'f4'), ('b', 'i4')])
    save('size', a, chunks=(2, 3, 4), compression='gzip', shuffle=True).attrs['element_size_um'] = [2, 0.5, 0.25]
    d = save('offset', a); d.attrs['resolution'] = [40., 4, 4]; d.attrs['offset'] = [400., 8, 12]
    d = save('labels', a)
    for i, l in enumerate('xyz'): d.dims[i].label = l
    v = np.random.default_rng(2).random((6, 7, 8, 3))
    f.create_dataset('vec', data=v, chunks=(3, 3, 3, 3), compression='gzip')
    np.save('vec1.npy', v[..., 1]); np.save('vecl.npy', np.sqrt((v**2).sum(-1)))
    t = np.random.default_rng(3).random((5, 6, 7, 8)); f.create_dataset('time', data=t); np.save('time3.npy', t[3])
    t = t[..., None]; d = f.create_dataset('tags', data=t); np.save('tags2.npy', t[2, ..., 0])
    d.attrs['axistags'] = '{"axes": [' + ', '.join('{"key": "%s", "typeFlags": 2}' % k for k in 'tzyxc') + ']}'
    f.create_dataset('lzf', data=a, chunks=True, compression='lzf')
    f.create_dataset('never', shape=(4, 4, 4), chunks=(2, 2, 2), dtype='f4')
    f.create_dataset('plain/inner', data=a); f['link'] = h5py.SoftLink('/size'); f['again/b'] = f['size']
"""

IMARIS = """import h5py, numpy as np
vol = np.random.default_rng(1).integers(0, 255, (2, 2, 10, 20, 30), dtype=np.uint8)
def text(o, k, v): o.attrs.create(k, np.frombuffer(str(v).encode(), dtype='S1'))
with h5py.File('a.ims', 'w') as f:
    image = f.create_group('DataSetInfo/Image')
    for k, v in dict(X=30, Y=20, Z=10, ExtMin0=-1.5, ExtMin1=0, ExtMin2=2, ExtMax0=13.5, ExtMax1=6, ExtMax2=12, Unit='um').items(): text(image, k, v)
    for c, name in enumerate(('DAPI', 'GFP')): text(f.create_group(f'DataSetInfo/Channel {c}'), 'Name', name)
    info = f.create_group('DataSetInfo/TimeInfo')
    text(info, 'TimePoint1', '2020-02-28 23:59:50.000'); text(info, 'TimePoint2', '2020-02-29 00:00:05.500')
    for r in range(2):
        for t in range(2):
            for c in range(2):
                v = vol[t, c][:, ::r + 1, ::r + 1]
                padded = np.full((16, 32, 32), 255, np.uint8); padded[:v.shape[0], :v.shape[1], :v.shape[2]] = v
                g = f.create_group(f'DataSet/ResolutionLevel {r}/TimePoint {t}/Channel {c}')
                g.create_dataset('Data', data=padded, chunks=(8, 16, 16), compression='gzip')
                for k, n in zip('ZYX', v.shape): text(g, 'ImageSize' + k, n)
np.save('gfp.npy', vol[1, 1]); np.save('half.npy', vol[0, 0][:, ::2, ::2])
"""

IMAGES = """import h5py, numpy as np
a = np.random.default_rng(1).random((6, 7, 8)); np.save('p.npy', a); np.save('c.npy', a[:5, :6, :7]); np.save('step.npy', a * 3)
def vtk(f, version, extent, **more):
    g = f.create_group('VTKHDF'); g.attrs['Version'] = version; g.attrs.create('Type', np.bytes_('ImageData'))
    g.attrs['WholeExtent'] = extent
    for k, v in more.items(): g.attrs[k] = v
    return g
with h5py.File('v.vtkhdf', 'w') as f:
    g = vtk(f, [1, 0], [2, 9, 0, 6, -1, 4], Origin=[1., 2., 3.], Spacing=[.5, .25, 2.], Direction=[0, -1, 0, 1, 0, 0, 0, 0, 1.])
    g['PointData/p'] = a; g['CellData/c'] = a[:5, :6, :7]; g['PointData/wrong'] = a[:4]
with h5py.File('t.vtkhdf', 'w') as f:
    g = vtk(f, [2, 0], [0, 7, 0, 6, 0, 5], Origin=[0., 0, 0], Spacing=[1., 1, 1])
    g['PointData/p'] = np.stack([a, a * 2, a * 3]); g['Steps/Values'] = [0., .5, 2.]; g['Steps'].attrs['NSteps'] = 3
    g['Steps/PointDataOffsets/p'] = [2, 1, 0]
with h5py.File('mesh.vtkhdf', 'w') as f: f.create_group('VTKHDF').attrs.create('Type', np.bytes_('UnstructuredGrid'))
with h5py.File('itk.h5', 'w') as f:
    g = f.create_group('ITKImage/0'); g['Dimension'] = [8, 7, 6]; g['Spacing'] = [1., 2., 3.]; g['Origin'] = [5., 6., 7.]
    g['Directions'] = [[0., 1, 0], [-1, 0, 0], [0, 0, 1]]; g['VoxelData'] = a
with h5py.File('bdv.h5', 'w') as f:
    f['s00/resolutions'] = [[1., 1, 1], [2, 2, 1]]; f['s00/subdivisions'] = [[4, 4, 4], [4, 4, 4]]
    for t in range(2):
        f[f't{t:05}/s00/0/cells'] = (a * 1000).astype('i2'); f[f't{t:05}/s00/1/cells'] = (a[:, :6:2, ::2] * 1000 + t).astype('i2')
np.save('bdv.npy', (a[:, :6:2, ::2] * 1000 + 1).astype('i2'))
"""


@needs_reader("hdf5", "numpy, h5py")
class Hdf5Test(WrittenVolumes):
    def test_datasets_of_all_types(self):
        self.python(ARRAYS)
        pairs = []
        for name in ("u1", "i1", "u2", "bei2", "u4", "i4", "i8", "beu8", "f2", "bef4", "f8", "bool", "size", "offset", "labels"):
            self.convert(f"a.h5:/{name}", "-o", f"read-{name}.npy")
            pairs.append((f"read-{name}.npy", f"{name}.npy"))
        for name, choice, out in (("vec", ("--component", 1), "vec1"), ("vec", ("--component", "length"), "vecl"),
                                  ("time", ("--volume", 3), "time3"), ("tags", ("--volume", 2), "tags2")):
            self.convert("a.h5", "--array", f"/{name}", *choice, "-o", f"read-{out}.npy")
            pairs.append((f"read-{out}.npy", f"{out}.npy"))
        self.assert_same_samples(pairs)

    def test_info_lists_what_can_be_read(self):
        self.python(ARRAYS)
        grids = {grid["name"]: grid for grid in json.loads(self.convert("info", "a.h5", "--json").text)[0]["grids"]}
        self.assertEqual((grids["/compound"]["type"], grids["/f2"]["type"], grids["/time"]["volumes"]), ("compound", "float16", 5))
        self.assertIn("/plain/inner", grids)
        self.assertFalse({"/again/b", "/link"} & set(grids), "one dataset is listed once")

    def test_attributes_place_the_samples(self):
        self.python(ARRAYS)
        for name, expected in (("size", [[0.25, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 2, 0]]), ("offset", [[4, 0, 0, 12], [0, 4, 0, 8], [0, 0, 40, 400]]),
                               ("labels", [[0, 0, 1, 0], [0, 1, 0, 0], [1, 0, 0, 0]])):
            report, _ = self.report(f"a.h5:/{name}", "--iso", 0.5, "-o", "a.ply")
            self.assertEqual(report["input"]["index_to_world"][:3], expected)

    def test_only_chunks_of_a_region_are_read(self):
        self.python(ARRAYS)
        report, _ = self.report("a.h5:/size", "--iso", 0.5, "--roi=-1,-1,-1,0.2,9,9", "-o", "a.ply")
        self.assertEqual(self.parts_left_out(report), (9, 18))

    def test_what_cannot_be_read_says_why(self):
        self.python(ARRAYS)
        for name, message in (("lzf", "found the filter 'lzf' (number 32000)"), ("never", "no program wrote them"),
                              ("compound", "compound"), ("nowhere", "/nowhere")):
            self.assert_fails(2, self.run_program(f"a.h5:/{name}", "--iso", 0.5, "-o", "a.ply"), message)
        self.assert_fails(2, self.run_program("a.h5:/size", "--level", 1, "--iso", 0.5, "-o", "a.ply"), "expected level 0")

    def test_imaris(self):
        self.python(IMARIS)
        self.convert("a.ims", "--grid", "GFP", "--volume", 1, "-o", "read-gfp.npy")
        self.convert("a.ims", "--grid", "DAPI", "--volume", 0, "--level", 1, "-o", "read-half.npy")
        self.assert_same_samples([("read-gfp.npy", "gfp.npy"), ("read-half.npy", "half.npy")])
        report, _ = self.report("a.ims", "--grid", "GFP", "--volume", 1, "--level", 1, "--iso", 99, "-o", "a.ply")
        self.assertEqual(report["input"]["index_to_world"][0], [1, 0, 0, -1])
        self.assertAlmostEqual(report["input"]["index_to_world"][1][3], 0.3)
        self.assertEqual(report["input"]["length_unit"], "um")
        grid = json.loads(self.convert("info", "a.ims", "--level", 1, "--json").text)[0]["grids"][1]
        self.assertEqual((grid["name"], grid["times"], grid["time_unit"], grid["box"]["max"]), ("GFP", [0, 15.5], "s", [14, 9, 9]))
        self.assert_fails(2, self.run_program("a.ims", "--grid", "GFP", "--level", 2, "--iso", 99, "-o", "b.ply"), "expected a level from 0 to 1")

    def test_vtkhdf(self):
        self.python(IMAGES)
        for name in ("p", "c"):
            self.convert("v.vtkhdf", "--array", name, "-o", f"read-{name}.npy")
        self.convert("t.vtkhdf", "--volume", 0, "-o", "read-step.npy")
        self.assert_same_samples([("read-p.npy", "p.npy"), ("read-c.npy", "c.npy"), ("read-step.npy", "step.npy")])
        for name, offsets in (("p", [1, 3, 1]), ("c", [0.875, 3.25, 2])):
            report, _ = self.report("v.vtkhdf", "--array", name, "--iso", 0.5, "-o", "a.ply")
            self.assertEqual([row[3] for row in report["input"]["index_to_world"][:3]], offsets)
            self.assertEqual([row[:3] for row in report["input"]["index_to_world"][:3]], [[0, -0.25, 0], [0.5, 0, 0], [0, 0, 2]])
        self.assertEqual(json.loads(self.convert("info", "t.vtkhdf", "--volume", 0, "--json").text)[0]["grids"][0]["times"], [0, 0.5, 2])
        self.assert_fails(2, self.run_program("v.vtkhdf", "--array", "wrong", "--iso", 0.5, "-o", "b.ply"), "of another size than its extent")
        self.assert_fails(2, self.run_program("mesh.vtkhdf", "--iso", 0.5, "-o", "b.ply"), "found type 'UnstructuredGrid'")

    def test_itk_and_bigdataviewer(self):
        self.python(IMAGES)
        self.convert("itk.h5", "-o", "read-itk.npy")
        self.convert("bdv.h5", "--level", 1, "--volume", 1, "-o", "read-bdv.npy")
        self.assert_same_samples([("read-itk.npy", "p.npy"), ("read-bdv.npy", "bdv.npy")])
        report, _ = self.report("itk.h5", "--iso", 0.5, "-o", "a.ply")
        self.assertEqual(report["input"]["index_to_world"][:3], [[0, -2, 0, 5], [1, 0, 0, 6], [0, 0, 3, 7]])
        self.assertEqual(report["input"]["world_space"], "left-posterior-superior")
        report, _ = self.report("bdv.h5", "--level", 1, "--volume", 0, "--iso", 500, "-o", "a.ply")
        self.assertEqual(report["input"]["index_to_world"][:3], [[2, 0, 0, 0.5], [0, 2, 0, 0.5], [0, 0, 1, 0]])
        (self.folder / "bdv.xml").write_text("<SpimData><ViewSetups><ViewSetup><id>1</id><voxelSize><size>9 9 9</size></voxelSize></ViewSetup><ViewSetup>"
                                             "<id>0</id><voxelSize><unit>um</unit><size>0.5 0.25 3.0</size></voxelSize></ViewSetup></ViewSetups></SpimData>")
        report, _ = self.report("bdv.h5", "--level", 1, "--volume", 0, "--iso", 500, "-o", "a.ply")
        self.assertEqual(report["input"]["index_to_world"][:3], [[1, 0, 0, 0.25], [0, 0.5, 0, 0.125], [0, 0, 3, 0]])
        self.assertEqual(report["input"]["length_unit"], "um")

    def test_virtual_datasets_need_their_files(self):
        self.python("""import h5py, numpy as np
a = np.random.default_rng(1).random((6, 7, 8)); np.save('a.npy', a)
with h5py.File('part.h5', 'w') as f: f['d'] = a
layout = h5py.VirtualLayout(shape=(6, 7, 8), dtype='f8'); layout[:] = h5py.VirtualSource('part.h5', 'd', shape=(6, 7, 8))
with h5py.File('whole.h5', 'w') as f: f.create_virtual_dataset('d', layout)""")
        self.convert("whole.h5", "-o", "read.npy")
        self.assert_same_samples([("read.npy", "a.npy")])
        (self.folder / "part.h5").unlink()
        self.assert_fails(2, self.run_program("whole.h5", "-o", "b.npy"), "a file of its virtual dataset is missing", "part.h5")

    def test_damaged_files_are_refused(self):
        self.python("""import h5py, numpy as np
with h5py.File('a.h5', 'w') as f: f.create_dataset('g/d', data=np.random.default_rng(1).random((5, 6, 7)), chunks=(2, 3, 4), compression='gzip')""")
        size = (self.folder / "a.h5").stat().st_size
        self.assert_refuses_damage("a.h5", [*range(8, 96, 16), *range(96, 2048, 127)], range(0, size, size // 15))


if __name__ == "__main__":
    main()

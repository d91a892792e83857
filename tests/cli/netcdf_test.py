"""netCDF files, read by the plug-in around its library: CF axes, missing values, time, uneven depths."""

import json
import pathlib
import sys
import unittest

from support import SOURCE, main

sys.path.insert(0, str(SOURCE / "tests" / "support"))

from written_volumes import WrittenVolumes, needs_reader  # noqa: E402

FERRET = pathlib.Path("/usr/share/ferret-vis/data")
LEVITUS = FERRET / "levitus_climatology.cdf"
ATLAS = FERRET / "ocean_atlas_subset.nc"
needs_ferret = unittest.skipUnless(LEVITUS.exists(), f"no {LEVITUS}: scripts/setup.sh test installs it")

# One variable in each version of the format: time without limit, z downward, y from north to south, x past 360 degrees.
WRITE = """import sys, netCDF4, numpy as np
kind, name = sys.argv[1:3]
d = netCDF4.Dataset(name, 'w', format=kind)
for n, k in (('when', None), ('lev', 6), ('lat', 7), ('lon', 8)): d.createDimension(n, k)
v = d.createVariable('when', 'f8', ('when',)); v.units = 'days since 1950-01-01'; v[:] = [0, 1.5]
v = d.createVariable('lev', 'f8', ('lev',)); v.units = 'hPa'; v[:] = [1000, 900, 800, 700, 600, 500]
v = d.createVariable('lat', 'f4', ('lat',)); v.standard_name = 'latitude'; v[:] = np.arange(7)[::-1] * .25
v = d.createVariable('lon', 'f4', ('lon',)); v.units = 'degrees_east'; v[:] = [356, 357, 358, 359, 0, 1, 2, 3]
a = np.random.default_rng(1).random((2, 6, 7, 8))
p = np.rint(a * 100).astype('i2'); p[p > 95] = -99
v = d.createVariable('p', 'i2', ('when', 'lev', 'lat', 'lon'), fill_value=-99)
v.set_auto_maskandscale(False); v.scale_factor = .5; v.add_offset = 10.; v[:] = p
q = np.where(p == -99, np.nan, p * .5 + 10)
np.save('p0.npy', q[0]); np.save('p1.npy', q[1])
f = a[0].astype('f4')
v = d.createVariable('f', 'f4', ('lev', 'lat', 'lon')); v.valid_range = np.array([.1, .9], 'f4'); v[:] = f
np.save('f.npy', np.where((f < np.float32(.1)) | (f > np.float32(.9)), np.nan, f))
u = (a[1] * 255).astype('u1').view('i1')
v = d.createVariable('u', 'i1', ('lev', 'lat', 'lon')); v.setncattr('_Unsigned', 'true'); v.set_auto_maskandscale(False); v[:] = u
np.save('u.npy', u.view('u1'))
d.close()
"""


@needs_reader("netcdf", "numpy, netCDF4")
class NetcdfTest(WrittenVolumes):
    def test_every_version_has_the_same_samples(self):
        names = {"NETCDF3_CLASSIC": "netCDF classic", "NETCDF3_64BIT_OFFSET": "netCDF 64-bit offset",
                 "NETCDF3_64BIT_DATA": "netCDF CDF-5", "NETCDF4_CLASSIC": "netCDF-4 classic model", "NETCDF4": "netCDF-4"}
        for kind, title in names.items():
            self.python(WRITE, kind, "a.nc")
            report, _ = self.report("a.nc", "--array", "f", "-o", "f-again.npy")
            self.assertEqual(report["input"]["format"], title)
            pairs = []
            for grid, volume, out in (("p", ("--volume", 0), "p0"), ("p", ("--volume", 1), "p1"), ("f", (), "f"), ("u", (), "u")):
                self.convert("a.nc", "--array", grid, *volume, "-o", f"read-{out}.npy")
                pairs.append((f"read-{out}.npy", f"{out}.npy"))
            self.assert_same_samples(pairs)

    def test_axes_place_the_samples(self):
        self.python(WRITE, "NETCDF4", "a.nc")
        report, run = self.report("a.nc", "--grid", "p", "--volume", 1, "--nan", "hole", "--iso", 30, "-o", "a.ply")
        self.assertEqual(report["input"]["index_to_world"][:3], [[1, 0, 0, 356], [0, -0.25, 0, 1.5], [0, 0, 100, -1000]])
        grids = {grid["name"]: grid for grid in json.loads(self.convert("info", "a.nc", "--json").text)[0]["grids"]}
        self.assertEqual((grids["p"]["times"], grids["p"]["time_unit"]), ([0, 1.5], "days since 1950-01-01"))
        self.assertIn("x is lon (degrees_east), y is lat (no unit), z is -lev (hPa); the units of the axes differ", run.err)

    def test_dimensions_may_come_in_any_order_and_in_groups(self):
        self.python("""import netCDF4, numpy as np
d = netCDF4.Dataset('g.nc', 'w')
for n, k in (('x', 8), ('y', 7), ('z', 6)):
    d.createDimension(n, k); v = d.createVariable(n, 'f8', (n,)); v[:] = np.arange(k) * k + 1; v.units = 'km'
v = d.createGroup('in').createGroup('ner').createVariable('q', 'f8', ('x', 'y', 'z'), zlib=True, chunksizes=(2, 7, 3))
a = np.random.default_rng(2).random((8, 7, 6)); v[:] = a; np.save('q.npy', a)
d.close()""")
        self.convert("g.nc", "-o", "read.npy")
        self.assert_same_samples([("read.npy", "q.npy")])
        report, _ = self.report("g.nc", "--iso", 0.5, "-o", "g.ply")
        self.assertEqual(report["input"]["index_to_world"][:3], [[0, 0, 8, 1], [0, 7, 0, 1], [6, 0, 0, 1]])
        self.assertEqual(report["input"]["length_unit"], "km")
        self.assertEqual(self.convert("g.nc:/in/ner/q", "--iso", 0.5, "-o", "h.ply").code, 0)
        # x = 1, 9, ..., 57: a box in the first two of four chunks along x.
        report, _ = self.report("g.nc", "--iso", 0.5, "--roi", "0,0,0,4,99,99", "-o", "part.ply")
        self.assertEqual(self.parts_left_out(report), (4, 8))

    def test_uneven_axes_need_resampling(self):
        self.python("""import netCDF4, numpy as np
d = netCDF4.Dataset('u.nc', 'w', format='NETCDF3_CLASSIC')
for n, k in (('z', 4), ('y', 5), ('x', 6)): d.createDimension(n, k)
v = d.createVariable('z', 'f8', ('z',)); v.units = 'm'; v.positive = 'down'; v[:] = [0, 10, 30, 35]
a = np.random.default_rng(3).random((4, 5, 6)).astype('f4'); a[1, 2, 3] = np.nan
d.createVariable('s', 'f4', ('z', 'y', 'x'))[:] = a
d.close()
out = np.stack([np.where(w == 0, a[k], a[min(k + 1, 3)] if w == 1 else a[k] + w * (a[min(k + 1, 3)].astype(float) - a[k]))
                for k, w in ((0, 0), (0, .5), (1, 0), (1, .25), (1, .5), (1, .75), (2, 0), (3, 0))]).astype('f4')
np.save('u.npy', out)""")
        run = self.run_program("u.nc", "--iso", 0.5, "-o", "u.ply")
        self.assert_fails(2, run, "its axis z has uneven distances: expected equal ones, found 5 to 20 m", "--resample")
        report, run = self.report("u.nc", "--resample", "--nan", "hole", "--iso", 0.5, "-o", "u.ply")
        self.assertEqual(report["input"]["index_to_world"][2], [0, 0, -5, 0])
        self.assertIn("the reader resamples axis z linearly from 4 samples, 5 to 20 m apart, to 8 samples, 5 apart", run.err)
        self.convert("u.nc", "--resample", "-o", "read.npy")
        self.assert_same_samples([("read.npy", "u.npy")])

    @needs_ferret
    def test_levitus_temperature(self):
        run = self.run_program(LEVITUS, "--grid", "TEMP", "--iso", 10, "-o", "a.ply")
        self.assert_fails(2, run, "ZAXLEVITR", "10 to 1000 METERS", "--resample")
        mesh, report = self.surface(LEVITUS, "--grid", "TEMP", "--resample", "--nan", "hole", "--iso", 10)
        # VTK 9.1 on the array that NumPy interpolates every 10 m, without the cells that lack a sample.
        self.assertAlmostEqual(mesh["area"] / 52778.4, 1, delta=0.005)
        self.assertEqual(report["input"]["index_to_world"][:3], [[1, 0, 0, 20.5], [0, 1, 0, -89.5], [0, 0, -10, 0]])

    @needs_ferret
    def test_ocean_atlas_is_a_sequence(self):
        self.convert(ATLAS, "--volume", "all", "--resample", "--nan", "hole", "--iso", 10, "-o", "t_{}.ply")
        self.assertEqual(len([name for name in self.files() if name.startswith("t_")]), 12)
        self.convert(ATLAS, "--volume", 11, "--resample", "--nan", "hole", "--iso", 10, "-o", "last.ply")
        grid = json.loads(self.convert("info", ATLAS, "--volume", 11, "--resample", "--json").text)[0]["grids"][0]
        self.assertEqual((grid["times"][11], grid["time_unit"]), (8401.335, "hour since 0000-01-01 00:00:00"))
        self.assertEqual((self.folder / "last.ply").read_bytes(), (self.folder / "t_11.ply").read_bytes())

    def test_damaged_files_are_refused(self):
        self.python(WRITE, "NETCDF3_CLASSIC", "a.nc")
        self.python("""import netCDF4
for kind, name in (('NETCDF3_CLASSIC', 'c.nc'), ('NETCDF4', 'd.nc')):
    d = netCDF4.Dataset(name, 'w', format=kind)
    for n in 'zyx': d.createDimension(n, 4)
    d.createVariable('s', 'f4', ('z', 'y', 'x'))[:] = 1.5
    d.close()""")
        size = (self.folder / "c.nc").stat().st_size
        self.assert_refuses_damage("c.nc", range(7, size - 256, 12), [*range(0, size - 256, 23), size - 200, size - 1])
        size = (self.folder / "d.nc").stat().st_size
        self.assert_refuses_damage("d.nc", range(8, size, size // 6), range(0, size, size // 8))


if __name__ == "__main__":
    main()

"""Sequences of particles as other programs wrote them, and the flat faces of a lattice. Some frames of each; the rest is
of the same kind."""

import json
import subprocess

from support import DATA, SOURCE, ProgramTest, main, needs_data, needs_program, read_glb

from particle_clouds import as_layers, face_spreads, polygons_of_ply, vtk_points, write_ply  # beside mesh_readers

PERI = "particles/lammps_peri"
FLIP = "particles/flip_quickliquid"
LATTICE = "particles/double_dam_break_frame_01_4732_particles.vtk"


class ParticleSequencesTest(ProgramTest):
    def convert_frames(self, pattern, frames, *options):
        """Frames in one run to GLB. Returns what each report says of the particles and of the mesh. The mesh is closed and
        manifold by the report, by the tests' own reader and by the validator of glTF."""
        self.convert(DATA / pattern, "--frames", frames, *options, "-o", "out_{:04}.glb", "--report", "report_{:04}.json")
        found = []
        for path in sorted(self.folder.glob("report_*.json")):
            report = json.loads(path.read_text())
            (facts,) = report["meshes"]
            self.assertEqual((facts["closed"], facts["open_edges"], facts["nonmanifold_edges"], facts["misoriented_edges"],
                              facts["nonmanifold_vertices"], facts["zero_area_triangles"]), (True, 0, 0, 0, 0, 0), path.name)
            found.append((report["particles"], facts))
        meshes = sorted(self.folder.glob("out_*.glb"))
        self.assertEqual(len(meshes), len(found))
        for path, (_, facts) in zip(meshes, found):
            (mesh,) = read_glb(path.read_bytes()).values()
            self.assertEqual((mesh.open_edges(), len(mesh.triangles)), (0, facts["triangles"]))
        run = subprocess.run(["node", SOURCE / "tests/gltf/validate.mjs", *meshes], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return found

    @needs_program("node")
    @needs_data(PERI)
    def test_a_peridynamic_target_that_is_shattered(self):
        """Millimeters in meters: only the file states its size."""
        found = self.convert_frames(f"{PERI}/peri_{{:04}}.csv", "0-1000x500", "--radius", "0.00025")
        self.assertEqual([particles["particles"] for particles, _ in found], [3487] * 3)
        cube = 0.0005 ** 3
        first = found[0][1]
        self.assertEqual(first["components"], 1)
        for _, facts in found:
            self.assertAlmostEqual(facts["volume"] / (3487 * cube), 1, delta=0.25)
        # It breaks into pieces.
        self.assertGreater(found[2][1]["components"], first["components"])
        self.assertGreater(found[2][1]["area"], first["area"])

    @needs_program("node")
    @needs_data(PERI)
    def test_damage_of_the_target_on_the_vertices_of_an_animation(self):
        self.convert(DATA / f"{PERI}/peri_{{:04}}.csv", "--frames", "0-1000x500", "--radius", "0.00025", "--attribute", "damage",
                     "--animate", "-o", "shattered.glb")
        run = subprocess.run(["node", SOURCE / "tests/gltf/validate.mjs", self.folder / "shattered.glb"], capture_output=True,
                             text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)

    @needs_program("node")
    @needs_data(FLIP)
    def test_a_flip_liquid_that_splashes(self):
        """Many particles a cell and no two frames with as many of them."""
        found = self.convert_frames(f"{FLIP}/flip_{{:04}}.ply", "5-35x15", "--radius", "0.047", "--cell-size", "1.5")
        counts = [particles["particles"] for particles, _ in found]
        self.assertEqual(len(set(counts)), 3)
        self.assertGreater(min(counts), 30000)
        for particles, facts in found:
            self.assertEqual(particles["radius"], 0.047)
            self.assertGreater(facts["volume"], 1)

    @needs_data(LATTICE)
    def test_faces_of_a_lattice_are_flat(self):
        """Two blocks, on either side of x = 0: no face's vertices are more than a tenth of a radius apart across it."""
        points = vtk_points(DATA / LATTICE)
        write_ply(self.folder / "lattice.ply", as_layers(points))
        self.convert("lattice.ply", "--radius", "0.025", "-o", "mesh.ply")
        vertices, _ = polygons_of_ply(self.folder / "mesh.ply")
        for side in (-1, 1):
            spreads = face_spreads([p for p in points if side * p[0] > 0], [v for v in vertices if side * v[0] > 0], 0.025)
            self.assertEqual(len(spreads), 6)
            self.assertLess(max(spreads), 0.1, spreads)


if __name__ == "__main__":
    main()

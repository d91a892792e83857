"""docs/schemas: the JSON that each command prints fits its schema, and the schemas list every word of the code's enums."""

import copy
import json
import random
import struct
import sys

from support import INSTALL, SOURCE, SPHERE, ProgramTest, main
from vdb_files import grid, vdb
from word_tables import CodeWords

try:
    import jsonschema
except ImportError:
    sys.exit(f"{sys.executable} has no module jsonschema: {INSTALL}, as python3-jsonschema, for Debian's own python3")

Validator = jsonschema.Draft202012Validator
SCHEMAS = {path.name.removesuffix(".schema.json"): json.loads(path.read_text())
           for path in sorted((SOURCE / "docs" / "schemas").glob("*.schema.json"))}
CODE = CodeWords(SOURCE)
METABALLS = SOURCE / "samples" / "metaballs.vdb"
RAW = ("--dims", "6,6,6", "--iso", "50")


USED = set()  # tables whose words a schema lists


def words(table):
    USED.add(table)
    return CODE.tables[table]


NONE = frozenset({None})
KINDS = CODE.literals("convert/json_values.cpp", "kind_name")
BACKENDS = CODE.literals("cli/backends.cpp", "parse_backends", r'"((?:cpu|gpu)[^"]*)"')
MEASURED = words("convert::Backend") - {"auto"}  # a backend that extracted a surface
PARTICLE_FILES = words("particle_io::ParticleFileFormat") - {"ply", "npy"}  # which are outputs of simulate alone
# For each schema the place of every enum, and the words that the code has for it.
ENUMS = {
    "bench": {"/$defs/method": words("extract::Method"), "/$defs/backend": BACKENDS},
    "check": {
        "/properties/unit": CODE.matches("convert/placement.cpp", r'LengthUnit\{"(\w+)"') | NONE,
        "/properties/required/items/properties/requirement": words("check::Requirement"),
        "/properties/findings/items/properties/who": CODE.matches("cli/check_findings.cpp", r'k(?:Slicer|Engine) = "(\w+)"'),
        "/$defs/shell": words("check::Shell"),
    },
    "compare": {},
    "devices": {},
    "formats": {"/items/properties/use": words("cli::FormatUse")},
    "gpu-threads": {"/properties/gpu_threads/items/properties/makers/items/properties/threads_by":
                    CODE.literals("gpu/thread_creation.cpp", "thread_maker_name")},
    "info": {
        "/$defs/note/properties/id": words("base::NoteId"),
        "/$defs/input/properties/grids/items/properties/kind": KINDS | NONE,
        "/$defs/input/properties/particles/properties/method": words("points::Method"),
        "/$defs/input/properties/field/properties/kind": KINDS,
        "/$defs/input/properties/field/properties/inside": words("field::FieldKind"),
        "/$defs/input/properties/field/properties/type": words("field::SampleType") | {"i64"},
        "/$defs/input/properties/field/properties/label_map/properties/kind": words("field::LabelMapKind"),
    },
    "manifest": {},
    "progress": {"/$defs/status": words("batch::FrameStatus")},
    "render": {},
    "report": {
        "/properties/status": CODE.matches("convert/outcome.cpp", r'[?:] "(done|failed)"'),
        # A report is about one frame, so its error is never that of a batch.
        "/properties/error/properties/kind": CODE.literals("convert/json_values.cpp", "kind_of") - {"frames"},
        "/properties/error/properties/exit_code":
            frozenset(int(code) for code in CODE.matches("base/error.hpp", r"return (\d+);")) - {5},
        "/properties/error/properties/reason": CODE.literals("convert/json_values.cpp", "reason_of") | NONE,
        "/properties/options/properties/axis_order": words("volume_io::AxisOrder") | NONE,
        # Raw files are an output of simulate alone.
        "/properties/options/properties/field_file/properties/format": words("volume_io::VolumeFileFormat") - {"raw"},
        "/properties/options/properties/particle_file/properties/format": PARTICLE_FILES,
        "/properties/options/properties/raw/properties/dtype": words("field::SampleType"),
        "/properties/options/properties/raw/properties/endian":
            CODE.matches("convert/conversion_job.cpp", r'"(big|little)"'),
        "/properties/options/properties/inside": words("field::FieldKind") | NONE,
        "/properties/options/properties/particles/properties/method": words("points::Method"),
        "/properties/options/properties/particles/properties/element_radii": words("points::ElementRadii") | NONE,
        "/properties/options/properties/particles/properties/deposit": words("points::Deposit"),
        "/properties/options/properties/particles/properties/not_finite": words("points::NonFiniteParticles"),
        "/properties/options/properties/attributes/items/properties/kind": words("base::AttributeKind") | NONE,
        "/properties/options/properties/backend": words("convert::Backend"),
        "/properties/options/properties/method": words("extract::Method"),
        "/properties/options/properties/voxel_faces": words("extract::VoxelFaces"),
        "/properties/options/properties/touching": words("convert::Touching"),
        "/properties/options/properties/require/items": words("check::Requirement") - {"normals"},
        "/properties/options/properties/normals": words("convert::Normals"),
        "/properties/options/properties/nan": words("extract::NanPolicy"),
        "/properties/options/properties/empty": words("convert::EmptyPolicy"),
        "/properties/options/properties/blurs/items/properties/kind": words("convert::BlurKind"),
        "/properties/options/properties/pieces/properties/least/properties/measure": words("edit::ComponentMeasure"),
        "/properties/options/properties/smooth/properties/method": words("edit::SmoothMethod"),
        "/properties/options/properties/hollow/properties/unit":
            CODE.matches("convert/placement.cpp", r'LengthUnit\{"(\w+)"') | {"voxel", "world"},
        "/properties/options/properties/filters/items/properties/filter": words("volume_io::LevelSetFilter"),
        "/properties/options/properties/kernel": words("field::ResampleKernel"),
        "/properties/options/properties/space": words("convert::Space"),
        "/properties/options/properties/up": words("convert::UpAxis"),
        "/properties/options/properties/to_space": words("convert::AnatomicalSpace") | NONE,
        "/properties/options/properties/format":
            words("mesh_io::MeshFormat") | words("volume_io::VolumeFileFormat") - {"raw"} | {"png"} | PARTICLE_FILES,
        "/properties/options/properties/compression": words("mesh_io::Compression"),
        "/properties/options/properties/error": words("field::Interpolation") | NONE,
        "/properties/attributes/items/properties/kind": words("base::AttributeKind"),
        "/properties/device/properties/backend": words("convert::Backend"),
        "/properties/input/properties/sample_type": words("field::SampleType"),
        "/properties/input/properties/kind": KINDS,
        "/properties/input/properties/inside": words("field::FieldKind"),
        "/properties/particles/properties/method": words("points::Method"),
        "/properties/stages/items/properties/stage": CODE.timed_stages(),
        "/properties/verification/items/properties/backends/items": MEASURED,
        "/properties/smoothings/items/properties/method": words("edit::SmoothMethod"),
        "/properties/simplifications/items/properties/asked/properties/unit":
            CODE.matches("convert/stages/mesh_simplify.cpp", r'[?:] "(world|voxel)"'),
        "/properties/packings/items/properties/compression": words("mesh_io::Compression"),
        "/$defs/colormap": words("edit::Colormap"),
        "/$defs/note/properties/id": words("base::NoteId"),
        "/$defs/error/properties/interpolant": words("field::Interpolation"),
        "/$defs/work/items/properties/what": words("convert::WorkTopic"),
        "/$defs/work/items/properties/done": words("convert::WorkDone"),
    },
    "stability": {"/$defs/method": words("extract::Method"), "/$defs/backend": BACKENDS},
    "stability-cases": {},
    "table": {"/$defs/status": words("batch::FrameStatus")},
    "verify": {
        "/$defs/mesh/properties/backend": MEASURED,
        "/$defs/mesh/properties/stages/items": CODE.stages_of_meshes(),
        "/$defs/backends/properties/backends/items": MEASURED,
    },
}
# Tables whose words no document has as a value, and why.
NOT_VALUES = {
    "batch::OutputWord": "words of output names",
    "cli::InsideChoice": "an option; the report has inside and away_from_zero",
    "cli::MissingPolicy": "an option of batches",
    "cli::OptionGroup": "headings of the help",
    "cli::PictureFile": "chosen by the name of the picture",
    "cli::ProgressStyle": "an option of batches",
    "convert::JsonDocument": "the member schema, which every test here compares",
    "convert::Key": "names of members; see test_the_report_has_every_figure",
    "convert::StageName": "the timed ones, and those of verify, are listed above",
    "render::BuiltInTransfer": "an option of render",
    "render::Shading": "an option of render",
    "render::UpAxis": "an option of render",
    "simulate::WaterOutput": "an option of simulate",
    "simulate::WaterRule": "an option of simulate",
}
# Definitions that several schemas have.
SHARED = ("box", "count", "index", "index_box", "length", "pair", "seconds", "spread", "vector")


def nodes(schema, at=""):
    """Every object within a schema, with its place."""
    if isinstance(schema, dict):
        yield at, schema
        for key, value in schema.items():
            yield from nodes(value, f"{at}/{key}")
    elif isinstance(schema, list):
        for index, value in enumerate(schema):
            yield from nodes(value, f"{at}/{index}")


def without_descriptions(schema):
    schema = copy.deepcopy(schema)
    for _, node in nodes(schema):
        if isinstance(node.get("description"), str):
            del node["description"]
    return schema


def places_of_objects(document, at=()):
    if isinstance(document, dict):
        yield at
    if isinstance(document, (dict, list)):
        for key, value in document.items() if isinstance(document, dict) else enumerate(document):
            yield from places_of_objects(value, (*at, key))


def changed(document, at, key, value):
    """A copy of the document with the member `key` of the object at that place set."""
    document = copy.deepcopy(document)
    place = document
    for step in at:
        place = place[step]
    place[key] = value
    return document


class SchemasTest(ProgramTest):
    def check(self, name, document):
        """A document that must fit its schema."""
        Validator(SCHEMAS[name]).validate(document)
        if name != "report":  # which has schema_version
            for part in document if isinstance(document, list) else [document]:
                self.assertEqual(part["schema"], f"isoextract/{name}/1")
                self.assertEqual(next(iter(part)), "schema")
        return document

    def printed(self, name, *arguments, code=0):
        run = self.run_program(*arguments, "--json")
        self.assertEqual(run.code, code, run.err)
        return self.check(name, json.loads(run.text))

    def written(self, name, option, *arguments, code=0):
        (self.folder / "written.json").unlink(missing_ok=True)
        run = self.run_program(*arguments, option, "written.json")
        self.assertEqual(run.code, code, run.err)
        return self.check(name, json.loads((self.folder / "written.json").read_text()))

    def report(self, *arguments, code=0):
        return self.written("report", "--report", *arguments, code=code)

    def lines(self, name, texts):
        """Lines of which only the first has the name of the document."""
        documents = [json.loads(text) for text in texts]
        for document in documents:
            Validator(SCHEMAS[name]).validate(document)
        self.assertEqual([document.get("schema") for document in documents],
                         [f"isoextract/{name}/1"] + [None] * (len(documents) - 1))
        return documents

    def manifest(self, path):
        rows = (self.folder / path).read_text().splitlines()
        return self.lines("manifest", [row[33:] for row in rows])

    def write_particles(self, name, shift=0):
        places = [(0.5 * i + shift, 0.5 * j, 0.5 * k) for i in range(5) for j in range(5) for k in range(5)]
        properties = "".join(f"property float {p}\n" for p in ("x", "y", "z", "pressure", "vx", "vy", "vz"))
        header = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(places)}\n{properties}end_header\n"
        body = b"".join(struct.pack("<7f", *place, place[0], *place) for place in places)
        (self.folder / name).write_bytes(header.encode() + body)

    def write_frames(self, numbers):
        for number in numbers:
            samples = bytearray(216)
            samples[86] = 100 + number
            (self.folder / f"in_{number:03}.raw").write_bytes(bytes(samples))

    def write_fire(self):
        hot = {(n % 8, n // 8 % 8, n // 64): float(n % 5) for n in range(8**3)}
        (self.folder / "fire.vdb").write_bytes(vdb(grid("density", hot), grid("heat", hot)))

    def test_the_schemas_are_schemas_of_the_documents_that_the_code_names(self):
        names = {word.split("/")[1] for word in CODE.tables["convert::JsonDocument"]}
        self.assertEqual(set(SCHEMAS), names | {"report"})
        for name, schema in SCHEMAS.items():
            Validator.check_schema(schema)
            self.assertEqual(schema["$id"], f"https://isoextract.invalid/schemas/{name}/1")
            consts = {node["const"] for _, node in nodes(schema) if str(node.get("const")).startswith("isoextract/")}
            self.assertEqual(consts, CODE.tables["convert::JsonDocument"] & {f"isoextract/{name}/1"})

    def test_shared_definitions_are_the_same(self):
        shared = dict.fromkeys(SHARED, 0)
        for name, schema in SCHEMAS.items():
            for definition, part in schema.get("$defs", {}).items():
                others = [other["$defs"][definition] for other in SCHEMAS.values() if definition in other.get("$defs", {})]
                if definition in SHARED:
                    shared[definition] += 1
                    for other in others:
                        self.assertEqual(without_descriptions(part), without_descriptions(other), f"{name}: {definition}")
        self.assertTrue(all(count > 1 for count in shared.values()), shared)
        row = set(SCHEMAS["table"]["$defs"])
        self.assertEqual({key: SCHEMAS["progress"]["$defs"][key] for key in row}, SCHEMAS["table"]["$defs"])

    def test_objects_are_closed(self):
        for name, schema in SCHEMAS.items():
            for at, node in nodes(schema):
                if "properties" in node and "object" in node.get("type", ()):
                    self.assertIs(node["additionalProperties"], False, f"{name}: {at}")

    def test_enums_are_those_of_the_code(self):
        self.assertEqual(set(ENUMS), set(SCHEMAS))
        for name, schema in SCHEMAS.items():
            listed = {at: node["enum"] for at, node in nodes(schema) if isinstance(node.get("enum"), list)}
            self.assertEqual(set(listed), set(ENUMS[name]), f"{name}: places of enums")
            for at, found in listed.items():
                self.assertEqual(len(found), len(set(found)), f"{name}: {at}")
                self.assertEqual(set(found), ENUMS[name][at], f"{name}: {at}")

    def test_every_table_of_words_is_in_a_schema_or_is_no_value(self):
        self.assertEqual(USED & set(NOT_VALUES), set())
        self.assertEqual(USED | set(NOT_VALUES), set(CODE.tables))

    def test_the_report_has_every_figure(self):
        members = {key for _, node in nodes(SCHEMAS["report"]) for key in node.get("properties", {})}
        of_tables = CODE.matches("convert/detail/place_report.cpp", r"Figure::of_tables\(Key::(\w+)")
        self.assertEqual(CODE.tables["convert::Key"] - members, of_tables - members)

    def test_reports_of_surfaces(self):
        self.report(SPHERE, "--iso", "0", "--iso", "0.2", "-o", "a.glb", "--error", "tricubic", "--normals", "smooth")
        self.report("demo:gyroid?size=24", "--iso", "0", "--cap", "--clip", "1,0,0,-0.5", "--smooth", "3", "--simplify", "0.1",
                    "--largest", "--fill-cavities", "--split-components", "-o", "a.glb", "--draco")
        self.report("demo:gyroid?size=24", "--iso", "0", "--drop-components", "5", "--triangles", "50%", "--smooth", "3:sinc",
                    "-o", "a.glb", "--meshopt", "--explain")
        self.report("demo:gyroid?size=24", "--iso", "auto", "--iso", "p40", "--resolution", "20,30,20", "--kernel", "cubic",
                    "--blur", "1", "--blur", "median:1", "-o", "a.obj", "--unit", "mm", "--to-unit", "m", "--center")
        self.report("demo:gyroid?size=24", "--iso", "0", "--backend", "gpu", "--verify", "-o", "a.ply")
        self.report("demo:gyroid?size=24", "--iso", "0", "--method", "voxels", "--verify", "-o", "a.ply")
        self.report(METABALLS, "--iso", "0.5", "--roi", "-9,-9,-9,9,9,9", "--empty", "skip", "-o", "a.stl")
        self.report(SPHERE, "--iso", "0", "-o", "a.png")

    def test_reports_of_labels_and_grids(self):
        label = random.Random(1)
        (self.folder / "l.raw").write_bytes(bytes(label.choice((0, 1, 2)) for _ in range(12**3)))
        (self.folder / "names.txt").write_text('1 255 0 0 1 1 1 "one"\n2 0 255 0 1 1 1 "two"\n')
        volume = ("l.raw", "--dims", "12,12,12", "--labels", "all")
        self.report(*volume, "-o", "l.glb", "--label-names", "names.txt")
        self.report(*volume, "-o", "l.glb", "--method", "surface-nets", "--relax", "4", "--smooth", "2")
        self.write_fire()
        self.report("fire.vdb", "--grid", "density", "--grid", "heat", "--iso", "1.5", "-o", "a.glb")
        self.report("fire.vdb", "--grid", "density", "--iso", "1.5", "-o", "a.glb", "--attribute", "t=heat", "--color-by",
                    "t:viridis:0,4", "--opacity", "0.5", "--up", "y")

    def test_reports_of_particles_with_attributes(self):
        self.write_particles("p.ply")
        carried = ("--attribute", "pressure", "--attribute", "v:vector", "--color-by", "pressure", "--scale", "2")
        for method in ("weight", "sph", "anisotropic"):
            document = self.report("p.ply", "--particles", method, *carried, "-o", "a.glb", "--explain", "--error")
            self.assertEqual([part["kind"] for part in document["attributes"]], ["scalar", "vector"])
            self.assertEqual(document["particles"]["method"], method)
        document = self.report("p.ply", "--particles", "sph", "--attribute", "dust?=dust", "-o", "a.ply")
        self.assertEqual(document["attributes"], [])

    def test_reports_of_particle_files_and_regions(self):
        self.write_particles("p.ply")
        document = self.report("p.ply", "--select", "pressure > 0.7", "--roi=-9,-9,0.7,9,9,9", "-o", "a.xyz", "--explain")
        self.assertEqual([part["particles"] for part in document["particle_files"]], [45])
        (self.folder / "box.xyz").write_text('1\nLattice="9 0 0 0 9 0 0 0 9" Properties=species:S:1:pos:R:3\nO 1 2 3\n')
        self.report("box.xyz", "--radii", "covalent", "-o", "a.bgeo")
        document = self.report("box.xyz", "--radii", "element", "--roi", "0,0,0,9,9,9", "-o", "a.ply", "--explain")
        self.assertEqual(document["particles"]["outside_region"], 0)

    def test_reports_of_failures(self):
        (self.folder / "bad.vdb").write_bytes(METABALLS.read_bytes()[:5000])
        for code, arguments in ((2, ("bad.vdb", "--iso", "0.5", "-o", "a.glb")), (2, ("none.vdb", "--iso", "0.5", "-o", "a.glb")),
                                (2, (SPHERE, "--iso", "90", "-o", "a.glb")), (1, (SPHERE, "--nonsense", "-o", "a.glb")),
                                (1, (SPHERE, "--iso", "0", "--method", "mc", "--relax", "2", "-o", "a.glb")),
                                (2, (SPHERE, "--iso", "0", "-o", "a.glb", "--memory-limit", "1B")),
                                (3, (SPHERE, "--iso", "0", "--backend", "gpu", "--device", "99", "-o", "a.glb")),
                                (4, (SPHERE, "--iso", "0", "-o", "no/where/a.glb"))):
            with self.subTest(arguments=arguments):
                document = self.report(*arguments, code=code)
                self.assertEqual((document["status"], document["error"]["exit_code"]), ("failed", code))

    def test_batches(self):
        self.write_frames((1, 2, 3, 5))
        (self.folder / "in_003.raw").write_bytes(b"short")
        batch = ("in_{:03}.raw", *RAW, "-o", "out/{:03}.ply", "--mkdir")
        run = self.run_program(*batch, "--error", "--table", "t.json", "--progress", "json", "--frames", "1-6")
        self.assertEqual(run.code, 5, run.err)
        events = self.lines("progress", [line for line in run.err.splitlines() if line.startswith("{")])
        self.assertEqual([event["event"] for event in events], ["begin", *["frame"] * 4, "end"])
        table = self.check("table", json.loads((self.folder / "t.json").read_text()))
        self.assertEqual([row["status"] for row in table], ["done", "done", "failed", "done"])
        for row, event in zip(table, sorted(events[1:-1], key=lambda event: event["frame"])):
            self.assertEqual({key: row[key] for key in row if key != "schema"},
                             {key: event[key] for key in row if key != "schema"})
        self.assertEqual(len(self.manifest("out/isoextract.manifest")), 4)

        self.write_frames((3,))
        (self.folder / "in_005.raw").write_bytes(bytes(216))
        table = self.written("table", "--table", *batch, "--error", "--resume", "--empty", "skip")
        self.assertEqual([row["status"] for row in table], ["done", "done", "done", "empty"])
        table = self.written("table", "--table", *batch, "--error", "--resume", "--empty", "skip")
        self.assertEqual([row["status"] for row in table], ["kept"] * 4)
        self.convert(*batch, "--error", "--empty", "skip")
        records = self.manifest("out/isoextract.manifest")
        self.assertTrue(any("begun_anew" in record for record in records))

    def test_batches_of_pieces_grids_and_particles(self):
        self.write_fire()
        (self.folder / "fire_1.vdb").write_bytes((self.folder / "fire.vdb").read_bytes())
        (self.folder / "fire_2.vdb").write_bytes((self.folder / "fire.vdb").read_bytes())
        table = self.written("table", "--table", "fire_{}.vdb", "--grid", "density", "--grid", "heat", "--iso", "auto",
                             "--iso", "1.5", "-o", "g/{}_{grid}_{iso}.ply", "--mkdir")
        self.assertEqual({surface["grid"] for row in table for surface in row["surfaces"]}, {"density", "heat"})
        self.manifest("g/isoextract.manifest")
        self.written("table", "--table", "demo:metaballs?size=24&time=0.{:02}", "--frames", "0-20x20", "--iso", "0.5",
                     "--split-components", "-o", "s/{}_{piece}.ply", "--mkdir")
        self.manifest("s/isoextract.manifest")
        for number in (1, 2):
            self.write_particles(f"p_{number}.ply", number)
        rows = self.written("table", "--table", "p_{}.ply", "--particles", "sph", "--attribute", "dust?=dust", "-o", "p/{}.glb",
                            "--mkdir")
        self.assertEqual([row["lacked_attributes"] for row in rows], [["dust"], ["dust"]])
        self.convert("p_{}.ply", "--particles", "sph", "-o", "q/{}.glb", "--mkdir", "--shard", "1/2")
        self.assertEqual(self.manifest("q/isoextract.1-of-2.manifest")[0]["shard"], [1, 2])

    def test_info(self):
        self.write_fire()
        self.write_particles("p.ply")
        self.write_frames((1, 2, 4))
        documents = self.printed("info", "info", SPHERE, METABALLS, "fire.vdb", "p.ply")
        self.assertEqual([document["input"] for document in documents][2:], ["fire.vdb", "p.ply"])
        sequence, = self.printed("info", "info", "in_{:03}.raw", "--dims", "6,6,6")
        self.assertEqual((sequence["count"], sequence["missing"]), (3, "3"))
        self.assertNotIn("schema", sequence["first"])
        (self.folder / "bad.vdb").write_bytes(METABALLS.read_bytes()[:5000])
        self.assertIn("error", self.printed("info", "info", "bad.vdb", SPHERE, code=2)[0])

    def test_meshes(self):
        self.convert(SPHERE, "--iso", "0", "--iso", "0.2", "-o", "a.glb")
        self.convert("demo:gyroid?size=24", "--iso", "0", "-o", "b.ply")
        self.printed("check", "check", "a.glb", "--require", "printable")
        self.printed("check", "check", "b.ply", "--require", "closed", "--weld", code=6)
        self.written("check", "--report", "check", "b.ply")
        self.write_particles("p.ply")
        for name in ("c.ply", "d.ply"):
            self.convert("p.ply", "--particles", "sph", "--attribute", "pressure", "-o", name)
        self.assertTrue(self.printed("compare", "compare", "c.ply", "d.ply")["attributes"]["both"])
        self.printed("compare", "compare", "a.glb", "b.ply", "--max-distance", "0.01", code=6)
        gyroid = ("demo:gyroid?size=24", "--iso", "0")
        self.printed("verify", "verify", *gyroid, "b.ply")
        self.printed("verify", "verify", *gyroid, "--cap", "b.ply", code=6)
        self.printed("verify", "verify", *gyroid)
        self.assertEqual(len(self.printed("verify", "verify", *gyroid, "--iso", "0.1")), 2)
        self.printed("verify", "verify", *gyroid, "--method", "voxels")

    def test_measurements(self):
        self.written("bench", "--json", "bench", SPHERE.partition("?")[0], "--sizes", "16,24", "--backends",
                     "cpu,gpu,gpu:points,gpu:rows", "--repeats", "1")
        self.written("bench", "--json", "bench", METABALLS, "--iso", "0.5", "--repeats", "1", "--backends", "cpu")
        self.written("gpu-threads", "--json", "bench", "gpu-threads", "--sizes", "16", "--repeats", "1")
        self.printed("stability", "stability", "--case", "jump", "--case", "float-max")
        self.printed("stability-cases", "stability", "--list")
        self.printed("devices", "devices")
        self.printed("formats", "formats")
        self.written("render", "--json", "render", SPHERE, "--size", "48x32", "--backend", "cpu", "-o", "a.png")
        (self.folder / "fire.vdb").write_bytes(vdb(grid("density", {(1, 1, 1): 1.0}), grid("t", {(1, 1, 1): 2000.0})))
        for emission in ("t", "t:0,5000"):
            self.written("render", "--json", "render", "fire.vdb", "--grid", "density", "--emission", emission, "--size", "48x32",
                         "--backend", "cpu", "-o", "a.png")

    def test_water(self):
        document = self.printed("stability", "stability", "--case", "water")
        self.assertEqual((len(document["rows"]), len(document["water"])), (0, 24))

    def samples(self):
        """A document of each schema, with the places of some of its enums."""
        self.write_frames((1,))
        self.write_particles("p.ply")
        self.convert(SPHERE, "--iso", "0", "-o", "a.glb")
        batch = self.run_program("in_{:03}.raw", *RAW, "--frames", "1", "-o", "o/{}.ply", "--mkdir", "--table", "t.json",
                                 "--progress", "json")
        events = self.lines("progress", [line for line in batch.err.splitlines() if line.startswith("{")])
        yield "table", self.check("table", json.loads((self.folder / "t.json").read_text())), [(0, "status")]
        for event in events:
            yield "progress", event, [("event",)] + ([("status",)] if "status" in event else [])
        for record in self.manifest("o/isoextract.manifest"):
            yield "manifest", record, []
        yield "report", self.report("p.ply", "--particles", "sph", "--attribute", "pressure", "--error", "-o", "a.ply"), [
            ("options", "backend"), ("device", "backend"), ("attributes", 0, "kind"), ("particles", "method"),
            ("stages", 0, "stage"), ("work", 0, "what"), ("work", 0, "done"), ("meshes", 0, "error", "interpolant")]
        yield "report", self.report(SPHERE, "--iso", "9", "-o", "b.ply", code=2), [("error", "kind"), ("error", "reason")]
        yield "info", self.printed("info", "info", SPHERE, "p.ply"), [(0, "field", "inside"), (1, "particles", "method")]
        yield "check", self.printed("check", "check", "a.glb", "--require", "closed"), [
            ("unit",), ("required", 0, "requirement"), ("findings", 0, "who"), ("mesh", "largest_components", 0, "shell")]
        yield "compare", self.printed("compare", "compare", "a.glb", "a.glb"), []
        yield "verify", self.printed("verify", "verify", SPHERE, "--iso", "0", "a.glb"), [("backend",), ("stages", 0)]
        yield "verify", self.printed("verify", "verify", SPHERE, "--iso", "0"), [("backends", 1)]
        yield "devices", self.printed("devices", "devices"), []
        yield "formats", self.printed("formats", "formats"), [(0, "use")]
        yield "stability-cases", self.printed("stability-cases", "stability", "--list"), []
        yield "stability", self.printed("stability", "stability", "--case", "jump"), [("rows", 0, "method"), ("rows", 0, "backend")]
        yield "bench", self.written("bench", "--json", "bench", "demo:sphere", "--sizes", "16", "--repeats", "1", "--backends",
                                    "cpu"), [("benchmarks", 0, "rows", 0, "method"), ("benchmarks", 0, "rows", 0, "backend")]
        yield "gpu-threads", self.written("gpu-threads", "--json", "bench", "gpu-threads", "--sizes", "16", "--repeats",
                                          "1"), [("gpu_threads", 0, "makers", 0, "threads_by")]
        yield "render", self.written("render", "--json", "render", SPHERE, "--size", "48x32", "--backend", "cpu", "-o",
                                     "a.png"), []

    def test_unknown_members_and_words_are_refused(self):
        seen = set()
        for name, document, enums in self.samples():
            seen.add(name)
            validator = Validator(SCHEMAS[name])
            validator.validate(document)
            for at in places_of_objects(document):
                self.assertFalse(validator.is_valid(changed(document, at, "unknown", "word")), f"{name}: {at}")
            for *at, key in enums:
                self.assertFalse(validator.is_valid(changed(document, at, key, "no such word")), f"{name}: {at} {key}")
            if isinstance(document, dict) and "schema" in document:
                self.assertFalse(validator.is_valid({**document, "schema": f"isoextract/{name}/2"}), name)
        self.assertEqual(seen, set(SCHEMAS))


if __name__ == "__main__":
    main()

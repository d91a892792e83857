#include "cli/convert_options.hpp"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/edit_options.hpp"
#include "cli/field_plan.hpp"
#include "cli/picture_plan.hpp"
#include "cli/shared_options.hpp"
#include "cli/vertex_plan.hpp"

namespace isoextract::cli {
namespace {

void declare_labels(const Group& group, ConvertFlags& flags) {
  group.value(
      "--labels", "all|L,...", flags.labels, parse_labels,
      "Of a label map, whose samples are integers, the surface of each of these labels as a mesh of its own, in "
      "place of --iso: all but 0, or those that are listed. They are called label L. With --method surface-nets, which "
      "is the default then, or voxels.");
}

void declare_cells(const Group& group, ConvertFlags& flags) {
  group.value("--relax", "N", flags.relaxations, parse_relaxations,
              fmt::format("With --method surface-nets: how many times vertices move towards their neighbours and back, "
                          "each within its cell; 0 leaves them at the corners of voxels (default: {}).",
                          extract::kUsualRelaxations));
  group.flag(
      "--no-merge", flags.no_merge,
      "With --method voxels: leave each face by itself, as two triangles. Otherwise coplanar faces are merged to "
      "large rectangles.");
  group.flag("--t-junctions", flags.t_junctions,
             "With --method voxels: draw each rectangle with two triangles, though corners of others lie within its "
             "sides. These are the fewest triangles, but the mesh is not closed edge by edge.");
}

void declare_simplification(const Group& group, ConvertFlags& flags) {
  group.value("--simplify", "ERR", flags.simplify, parse_simplify_bound,
              "Leave out triangles as long as no point of either mesh is farther than ERR from the other: 0.1 or "
              "0.1voxel in voxels, 0.5world in the units of the written mesh. The distance is measured and told. Open "
              "borders stay within ERR, too, with fewer vertices.");
  group.value("--triangles", "N|P%", flags.triangles, parse_triangle_count,
              "Leave N triangles of each surface, or P percent of them, where its topology lets that many go; how far "
              "the surface moved is measured and told. With --simplify it ends where the first of the two is reached.");
}

void declare_backend(const Group& group, ConvertFlags& flags) {
  group.choice("--backend", flags.backend,
               "What extracts: the processor, a GPU, or a GPU where there is one that is not software (default: "
               "cpu). The triangles are the same.");
}

void declare_convert_surface(CLI::App& app, ConvertFlags& flags) {
  const Group group(app, "Surface");
  group.values("--iso", "V", flags.isos, parse_iso,
               fmt::format("{} Several times for several surfaces. (default: 0 of a level set, the usual value of "
                           "particles; other inputs need one).",
                           kIsoText));
  declare_surface(group, flags.surface);
  declare_labels(group, flags);
  group.value<std::string>(
      "--label-names", "FILE", flags.label_names, parse_text,
      "Names and colours of labels, as a table that ITK-SNAP, FreeSurfer or 3D Slicer writes: meshes are called so, "
      "and have these colours in glb, gltf and ply.");
  declare_cells(group, flags);
  group.choice("--normals", flags.normals,
               "Normals to store: none, one a triangle, or one a vertex: smooth is the field's gradient, area the mean "
               "of the triangles around by their areas (default: smooth for glb and gltf, none for ply, obj and drc; "
               "stl always has one a triangle). With --cap and --simplify a vertex gets a normal for each side of a "
               "crease.");
  declare_simplification(group, flags);
  group.choice("--empty", flags.empty,
               "What to do where there is no surface: fail, write no file and remove an old one of that name, or write "
               "an empty one (default: error).");
}

void declare_vertices(CLI::App& app, ConvertFlags& flags) {
  const Group group(app, "Vertices");
  group.values(
      "--attribute", "NAME[?][=FROM][:KIND][:KEY=V...]", flags.attributes, parse_attribute,
      "Give the vertices this attribute, interpolated; several times for several. FROM is an attribute of the "
      "particles, or of a volume another grid of the file (velocity[x], or velocity with its components), "
      "another file, or a grid of one: FILE.vdb[GRID]. Without it, it is called NAME there too. With '?' an input "
      "that lacks it is converted without it. KIND is scalar, color, vector, point or normal (default: as the file "
      "says, else by the name: v, velocity, N, Cd, P, ...): vectors, points and normals turn and scale with the mesh. "
      "KEY is spacing or origin, for a file that states none and has not the input's shape, or nodata, in place of "
      "--nodata, or volume or component, of a file of several. For glb, gltf, ply and drc.");
  std::vector<std::string_view> maps;
  for (const auto& word : words_of(convert::Colormap{})) maps.push_back(word.word);
  group.value(
      "--color-by", "NAME[?][=FROM][:KEY=V...][:MAP][:MIN,MAX]", flags.colour, parse_colour,
      fmt::format("Colour the vertices by this attribute, of several components by their length in the input, from MIN "
                  "to MAX (default: the range over the vertices of each surface). --color-by iso[:MAP][:MIN,MAX] gives "
                  "each surface of a glb or gltf a colour by its iso value, and outer ones let inner ones be "
                  "seen. MAP is one of {} (default: {}).",
                  fmt::join(maps, ", "), maps.front()));
  group.value("--opacity", "A[,B...]", flags.opacity, parse_opacity,
              "Opacity of the surfaces of a glb or gltf, above 0 and at most 1: one for all, or one for each --iso in "
              "their order (default: opaque; with --color-by iso from 0.25 for the outermost to 1 for the innermost).");
}

Result<batch::ShardChoice> parse_shard(std::string_view text) { return batch::parse_shard(std::string(text)); }

void declare_frames(CLI::App& app, BatchFlags& flags) {
  const Group group(app, "Frames");
  declare_frame_range(group, flags.frames,
                      "Frames to convert, such as 1-240, 1-240x2 or 1-10,20 (default: all that match INPUT).");
  group.choice("--missing", flags.missing,
               "What to do where frames are not there: convert the others and exit with 5, or tell of it only "
               "(default: error for those that --frames names, note for gaps in the numbering).");
  group.value<std::string>(
      "--iso-table", "FILE", flags.iso_table, parse_text,
      "Iso values by frame, in place of --iso and in its words: a CSV file with the columns frame and iso.");
  group.flag("--animate", flags.animate,
             "Write all frames into one .glb that plays them, named after -o. The first frame is at 0 seconds, gaps in "
             "the numbering keep their time, and a frame that fails is left out: the one before it is shown longer. "
             "What does not fit into one file of 4 GiB goes on in NAME.part2.glb.");
  group.value("--fps", "N", flags.fps, parse_positive,
              "Frames per second of --animate (default: 24). Blender 3.4 rounds it to a whole number when it opens the "
              "file.");
  group.value("--jobs", "N", flags.jobs, parse_thread_count,
              "Frames to convert at a time, as far as --memory-limit lets them; they share --threads, and a GPU draws "
              "one after another (default: as many as threads). The output does not depend on it.");
  group.flag("--resume", flags.resume,
             "Do only what is not done: frames whose record, input and output are what the manifest in the folder of "
             "the outputs says are left alone.");
  group.flag("--fail-fast", flags.fail_fast, "End with the first frame that fails (default: go on, and exit with 5).");
  group.flag("--no-clobber", flags.no_clobber, "Leave out frames of which a file is there, whoever wrote it.");
  group.flag("--mkdir", flags.make_folders, "Make the folders of the outputs; so does a slash at the end of -o.");
  group.flag("--dry-run", flags.dry_run,
             "Show the frames, their files and an estimate of memory on stdout, and do nothing.");
  group.value<std::string>("--table", "FILE", flags.table, parse_text,
                           "Write a table of all frames, .csv or .json: triangles, area, volume, time, memory.");
  group.value<std::string>("--plot", "FILE", flags.plot, parse_text,
                           "Draw the table over the frames with gnuplot, as .svg or .png.");
  group.choice("--progress", flags.progress,
               "How to tell on stderr how far it is: a bar on a terminal, a line of JSON an event, or not at all "
               "(default: bar).");
  group.value("--shard", "K/N|auto", flags.shard, parse_shard,
              "Convert every N-th frame from the K-th on, for N machines; 'isoextract merge' joins what they did. auto "
              "takes K and N from the variables of a Slurm array or an indexed Kubernetes job (default: all frames).");
}

void declare_packing(const Group& group, ConvertFlags& flags) {
  using Bits = std::optional<std::uint64_t>;
  std::vector<Choice<Bits>> bits{{"auto", Bits()}};
  for (std::uint64_t b = meshes::kMinPositionBits; b <= meshes::kMaxPositionBits; ++b) {
    bits.push_back({fmt::format("{}", b), b});
  }
  group
      .choice("--draco", flags.draco, std::move(bits),
              "Compress glb or gltf with Draco (KHR_draco_mesh_compression); drc always is. Positions are rounded to a "
              "lattice that all regions of a volume share: its step is at most a 32nd of a voxel (auto, the default), "
              "or such that the whole volume takes so many bits. What the file unpacks to is compared with the mesh, "
              "and how far vertices moved is told.")
      ->expected(0, 1);
  group.flag("--quantize", flags.quantize,
             "Write glb or gltf with positions of 16 bits, on the same lattice, and normals of 8 "
             "(KHR_mesh_quantization).");
  group.flag("--meshopt", flags.meshopt,
             "Compress glb or gltf with meshoptimizer (EXT_meshopt_compression), without loss; smaller with --quantize "
             "and --optimize-order.");
  group.flag("--optimize-order", flags.optimize_order,
             "Put vertices and triangles into an order that graphics cards and compression like.");
}

void declare_output(CLI::App& app, ConvertFlags& flags) {
  const Group group(app, "Output");
  group.value<std::string>(
      "-o,--output", "FILE", flags.output, parse_text,
      "The mesh file; its extension chooses the format. A name that ends in .vdb is that of the field "
      "itself, resampled and filtered where that is asked for, as an OpenVDB file in place of a "
      "mesh, which needs no --iso and takes no option of surfaces. One that ends in .png is that of a picture of the "
      "surfaces. (default: the input's name with .glb, in "
      "the current folder; an input from stdin has none). '-' is stdout and needs --format. "
      "'{iso}' stands for the iso value as it was given, be it a number or a word such as p99, and gives each "
      "its own file; '{piece}' is the number of a piece, with --split-components. A file gets its name when it is "
      "whole. What a killed run leaves, on some file systems, is called "
      ".isoextract-HOST-PID-N and stays until the next run writes into that folder.");
  std::vector<Choice<OutputFormat>> formats;
  for (const meshes::MeshFormatInfo& info : meshes::mesh_formats()) {
    formats.push_back({std::string(info.name), {info.format}});
  }
  formats.push_back({std::string(kPictureFormat), {std::nullopt, true}});
  formats.push_back({std::string(kFieldFormat), {}});
  group.choice("--format", flags.format, std::move(formats), "Format of the output, whatever the extension.");
  group.value<render::PictureSize>("--size", "WxH", flags.size, parse_picture_size,
                                   "Of a picture, in pixels (default: 960x720).");
  group.value<render::ViewAngles>(
      "--camera", "AZ,EL[,DISTANCE]", flags.camera, render::parse_view_angles,
      "Where a picture is drawn from: degrees around the up axis from the front, degrees above the ground, and how far "
      "from the middle of the surfaces (default: 35,20, and so far that all of them are seen).");
  group.value("--look-at", "X,Y,Z", flags.look_at, parse_vector,
              "What the camera of a picture looks at, in the coordinates of the surfaces, in place of their middle. "
              "With the distance of --camera all frames of a sequence have one camera.");
  group.flag("--half", flags.half, "Store a field with values of 16 bits: files of half the size or less.");
  group.value<std::string>("--report", "FILE", flags.report, parse_text,
                           "Write a JSON report of the conversion: options, input, stages with time and memory, what "
                           "was left out, and the facts of each mesh, which take time and memory of their own. Of a "
                           "conversion that fails, it says why.");
  group.value<std::string>("--html", "FILE", flags.html, parse_text,
                           "Write a page about the conversion, or all frames of it, that needs no other file: pictures "
                           "of at most 12 of its meshes, a table and, of several frames, plots by gnuplot, the error "
                           "where it is measured, what was left out.");
  group.value<std::string>("--contact-sheet", "FILE", flags.contact_sheet, parse_text,
                           "Draw the meshes of at most 60 frames side by side, as a .png.");
  group.flag("--ascii", flags.ascii, "Write ply or stl as text instead of binary.");
  declare_packing(group, flags);
}

}  // namespace

void declare_convert(CLI::App& app, ConvertFlags& flags) {
  declare_input(app, flags.input, "INPUT", "The volume or particles to convert", VolumesTaken::all);
  declare_particles(app, flags.particles);
  declare_convert_surface(app, flags);
  declare_edits(app, flags.edits);
  declare_vertices(app, flags);
  declare_frames(app, flags.batch);
  declare_placement(app, flags.placement);
  declare_output(app, flags);
  const Group convert_run(app, "Run");
  convert_run
      .choice("--error", flags.error,
              "Measure how far the mesh is from the isosurface of the data, interpolated linearly along each axis "
              "(the default) or smoothly; of demo fields also how far from the formula.")
      ->expected(0, 1);
  declare_backend(convert_run, flags);
  declare_device(convert_run, flags.device);
  convert_run.flag("--verify", flags.verify,
                   "Extract with the other backend as well, CPU or GPU, and compare triangle by triangle. Where they "
                   "differ, exit with code 6 and do not write the file.");
  convert_run.value<std::string>(
      "--config", "FILE", flags.config, parse_text,
      "Take options from a TOML file: keys are their long names without dashes, and input; an option that may be given "
      "several times takes a list, one without a value takes true. What the command line has as well wins over the "
      "file. Relative paths in it are relative to the current folder.");
  convert_run.flag("--explain", flags.explain, "Tell what was left out and why, with counts and times.");
  declare_run(app, flags.run);
}

void declare_verify(CLI::App& app, VerifyFlags& flags) {
  declare_input(app, flags.input, "INPUT", "The volume or particles to verify with");
  Group(app, "Input")
      .value<std::string>(
          "MESH", "MESH", flags.mesh, parse_text,
          "A mesh that was written from it: .glb, .gltf, .ply, .obj, .stl or .drc; its extension says how it "
          "was placed unless options do. Without one the backends are compared with each other.");
  declare_particles(app, flags.particles);
  const Group surface(app, "Surface");
  surface.values("--iso", "V", flags.isos, parse_iso,
                 fmt::format("{} Several times for the several surfaces of a mesh. (default: 0 of a level set, the "
                             "usual value of particles; other inputs need one).",
                             kIsoText));
  declare_surface(surface, flags.surface);
  declare_labels(surface, flags);
  declare_cells(surface, flags);
  declare_simplification(surface, flags);
  declare_edits(app, flags.edits);
  declare_placement(app, flags.placement);
  Group(app, "Output").flag("--json", flags.json, "Report as JSON.");
  const Group run(app, "Run");
  declare_backend(run, flags);
  declare_device(run, flags.device);
  declare_run(app, flags.run);
}

}  // namespace isoextract::cli

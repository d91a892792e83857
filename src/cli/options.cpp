#include "cli/options.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/version.hpp"
#include "cli/help_topics.hpp"
#include "cli/option_group.hpp"
#include "field/demo_field.hpp"

namespace isoextract::cli {
namespace {

// Those that are files.
std::vector<Choice<std::string>> input_formats() {
  std::vector<Choice<std::string>> formats;
  for (const volumes::VolumeFormat* format : volumes::volume_formats()) {
    const volumes::FormatDescription& about = format->about();
    if (about.prefix.empty()) formats.push_back({about.id, about.id});
  }
  return formats;
}

std::vector<Choice<convert::LengthUnit>> units() {
  std::vector<Choice<convert::LengthUnit>> choices;
  for (const convert::LengthUnit& unit : convert::length_units()) choices.push_back({std::string(unit.name), unit});
  return choices;
}

constexpr const char* kMemoryLimitText =
    "Refuse an input that needs more memory than this, such as 512M or 8G (default: the machine's memory). Samples "
    "that are mapped from their file, not copied, need none.";

// `what` says of the inputs what they are for.
void declare_input(CLI::App& app, InputFlags& flags, const std::string& metavar, const std::string& what) {
  const Group group(app, "Input");
  group.values<std::string>(
      "INPUT", metavar, flags.inputs, parse_text,
      fmt::format("{}: a path, - for stdin, or demo:NAME (see 'isoextract help demo'). A file that is "
                  "named like a command is written ./NAME.",
                  what));
  group.value<std::string>("--grid", "NAME", flags.grid, parse_text,
                           "Grid of a VDB file, as 'isoextract info' lists it: NAME, or NAME[k] where names repeat.");
  group.value("--volume", "K|all", flags.volume, parse_volume,
              "Volume of a NIfTI, NRRD or NPY file that holds several, such as time steps: its number, counted from 0, "
              "or each of them. 'isoextract info' tells how many there are.");
  group.choice("--input-format", flags.format, input_formats(),
               "Format of the input (default: by content, then by extension).");
  group.value("--dims", "NX,NY,NZ", flags.dims, parse_dims,
              "Samples along x (fastest), y and z of a raw file. 48x62x42 is the same as 48,62,42.");
  group.choice("--dtype", flags.dtype, "Type of a raw file's samples (default: u8).");
  group.choice("--endian", flags.endian, {{"little", std::endian::little}, {"big", std::endian::big}},
               "Byte order of a raw file's samples (default: little).");
  group.value("--skip", "BYTES", flags.skip, parse_size, "Bytes before a raw file's first sample (default: 0).");
  group.value("--spacing", "SX,SY,SZ", flags.spacing, parse_spacing,
              "Distance of the samples along each axis, or one number for all; replaces what the file says.");
  group.value("--origin", "X,Y,Z", flags.origin, parse_vector,
              "World position of the first sample; replaces what the file says.");
  group.choice("--inside", flags.inside,
               "Which side of the iso value is inside: above as in densities, or below as in level sets (default: as "
               "the file says, else above). A value equal to the iso value is outside.");
  group.value("--memory-limit", "SIZE", flags.memory_limit, parse_size, kMemoryLimitText);
}

constexpr const char* kQuietText = "Say nothing but errors and, on stdout, results.";

// Last of a command's options.
void declare_verbosity(const Group& group, RunFlags& flags) {
  group.flag("-q,--quiet", flags.quiet, kQuietText);
  group.flag("-v,--verbose", flags.verbose, "Say also what each stage took, and the peak of memory.");
  group.help_flag();
}

void declare_run(CLI::App& app, RunFlags& flags) {
  const Group group(app, "Run");
  group.value("--threads", "N", flags.threads, parse_thread_count,
              "Threads to use (default: all). The output does not depend on it. With 1 no other is started.");
  declare_verbosity(group, flags);
}

void declare_nan(const Group& group, std::optional<extract::NanPolicy>& policy) {
  group.choice("--nan", policy,
               "What a sample that is not a number means: the end, outside, or a hole in the surface, left by the "
               "cells that touch it (default: error).");
}

void declare_device(const Group& group, DeviceFlags& flags) {
  group.value("--device", "N|cuda:N|NAME", flags.device, parse_device,
              "The GPU to use: its number, its number in CUDA, or a part of its name; 'isoextract devices' lists them "
              "(default: the first that is not software).");
  group.value("--gpu-memory", "SIZE", flags.gpu_memory, parse_size,
              "What samples and triangles may take on the GPU at a time; larger volumes pass through in slabs, and the "
              "output does not depend on it (default: a quarter of what the GPU has, 1G where it does not tell).");
}

// "Marching cubes, or marching tetrahedra with six a cell"
std::string method_help() {
  std::vector<std::string_view> methods;
  for (const extract::MethodInfo& method : extract::kMethods) methods.push_back(method.help);
  std::string text = fmt::format("{}", fmt::join(methods, ", or "));
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

void declare_backends(const Group& group, std::optional<std::vector<NamedBackend>>& backends,
                      const std::string& by_default) {
  group.value(
      "--backends", "B,B,...", backends, parse_backends,
      fmt::format("Of cpu, gpu, gpu:points (marching cubes without tessellation) and gpu:rows (cells row by row "
                  "instead of in groups of 2 x 2 x 2) (default: {}).",
                  by_default));
}

void declare_surface(const Group& group, SurfaceFlags& flags) {
  group.choice("--method", flags.method, fmt::format("{} (default: {}).", method_help(), extract::method_ids()[0]));
  group.value("--roi", "X0,Y0,Z0,X1,Y1,Z1", flags.roi, parse_box,
              "Only the samples in this box, given by its smaller and larger corner in the input's world coordinates "
              "(with --space index in voxel coordinates).");
  group.value("--resolution", "NX,NY,NZ", flags.resolution, parse_resolution,
              "Extract from a grid of so many samples over the same box, or one number for all axes; between the "
              "input's samples, values are linear along each axis (default: the input's samples themselves). A sparse "
              "grid becomes dense: its active voxels and one of background around them. --space index and --roi keep "
              "the input's voxel coordinates, --error its voxels; those of --simplify are the grid's.");
  group.flag("--cap", flags.cap, "Close the surface where it leaves the data or the --roi.");
  declare_nan(group, flags.nan);
}

void declare_convert_surface(CLI::App& app, ConvertFlags& flags) {
  const Group group(app, "Surface");
  group.values("--iso", "V", flags.isos, parse_number,
               "The value whose surface is extracted. Required; several times for several surfaces. 'isoextract info "
               "INPUT' suggests one.");
  declare_surface(group, flags.surface);
  group.choice("--normals", flags.normals,

               "Normals to store: none, one a triangle, or the field's gradient at each vertex (default: smooth for "
               "glb and gltf, none for ply, obj and drc; stl always has one a triangle).");
  group.value("--simplify", "ERR", flags.simplify, parse_simplify_bound,
              "Leave out triangles as long as no point of either mesh is farther than ERR from the other: 0.1 or "
              "0.1voxel in voxels, 0.5world in the units of the written mesh. The distance is measured and told. Open "
              "borders keep their vertices.");
  group.choice("--empty", flags.empty,

               "What to do where there is no surface: fail, write no file and remove an old one of that name, or write "
               "an empty one (default: error).");
}

Result<batch::FrameRange> parse_frames(std::string_view text) { return batch::FrameRange::parse(text); }
Result<batch::Shard> parse_shard(std::string_view text) { return batch::parse_shard(std::string(text)); }

void declare_frames(CLI::App& app, BatchFlags& flags) {
  const Group group(app, "Frames");
  group.value("--frames", "A-BxS,...", flags.frames, parse_frames,
              "Frames to convert, such as 1-240, 1-240x2 or 1-10,20 (default: all that match INPUT). Those that are "
              "not there are told.");
  group.value<std::string>("--iso-table", "FILE", flags.iso_table, parse_text,
                           "Iso values by frame, in place of --iso: a CSV file with the columns frame and iso.");
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
  group.value("--shard", "K/N", flags.shard, parse_shard,
              "Convert every N-th frame from the K-th on, for N machines; 'isoextract merge' joins what they did "
              "(default: as the variables of a Slurm array or an indexed Kubernetes job say).");
}

void declare_quiet(CLI::App& app, bool& quiet) {
  const Group run(app, "Run");
  run.flag("-q,--quiet", quiet, kQuietText);
  run.help_flag();
}

void declare_merge(CLI::App& app, MergeFlags& flags) {
  Group(app, "Input")
      .value<std::string>("FOLDER", "FOLDER", flags.folder, parse_text,
                          "The folder of the outputs, where the manifests of the shards are.");
  declare_quiet(app, flags.quiet);
}

void declare_placement(CLI::App& app, PlacementFlags& flags) {
  const Group group(app, "Placement");
  group.choice("--space", flags.space,
               "Coordinates of the mesh: the input's world, or voxels counted from 0 (default: world).");
  group.choice("--up", flags.up,
               "The axis of the input's world that points up (default: z). glb and gltf prescribe y up, so z-up "
               "input is turned for them: (x, y, z) becomes (x, z, -y). ply, obj, stl and drc keep the input's axes.");
  group.value("--scale", "S", flags.scale, parse_positive, "Multiply the world coordinates by S.");
  group.choice("--unit", flags.unit, units(),
               "Unit of the input's world; the mesh is written in metres, as glTF prescribes (default: coordinates "
               "are written as they are). Not together with --scale.");
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
  group.value<std::string>("-o,--output", "FILE", flags.output, parse_text,
                           "The mesh file; its extension chooses the format (default: the input's name with .glb, in "
                           "the current folder; an input from stdin has none). '-' is stdout and needs --format. "
                           "'{iso}' stands for the iso value and gives each its own file. A file gets its name when it "
                           "is whole. What a killed run leaves, on some file systems, is called "
                           ".isoextract-HOST-PID-N and stays until the next run writes into that folder.");
  group.choice("--format", flags.format, "Format of the mesh, whatever the extension.");
  group.value<std::string>("--report", "FILE", flags.report, parse_text,
                           "Write a JSON report of the conversion: options, input, stages with time and memory, what "
                           "was left out, and the facts of each mesh, which take time and memory of their own. Of a "
                           "conversion that fails, it says why.");
  group.flag("--ascii", flags.ascii, "Write ply or stl as text instead of binary.");
  declare_packing(group, flags);
}

void declare_verify(CLI::App& app, VerifyFlags& flags) {
  declare_input(app, flags.input, "INPUT", "The volume to verify with");
  Group(app, "Input")
      .value<std::string>(
          "MESH", "MESH", flags.mesh, parse_text,
          "A mesh that was written from it: .glb, .gltf, .ply, .obj, .stl or .drc; its extension says how it "
          "was placed unless options do. Without one the backends are compared with each other.");
  const Group surface(app, "Surface");
  surface.values("--iso", "V", flags.isos, parse_number,
                 "The value whose surface is verified. Required; several times for the several surfaces of a mesh.");
  declare_surface(surface, flags.surface);
  declare_placement(app, flags.placement);
  Group(app, "Output").flag("--json", flags.json, "Report as JSON.");
  declare_device(Group(app, "Run"), flags.device);
  declare_run(app, flags.run);
}

void declare_compare(CLI::App& app, CompareFlags& flags) {
  const Group input(app, "Input");
  input.values<std::string>(
      "FILE", "FILE", flags.meshes, parse_text,
      "The two meshes: .glb, .gltf, .ply, .obj, .stl or .drc. Corners without connectivity, as in "
      "stl, are welded where their coordinates are equal.");
  input.choice("--up", flags.up,
               "Where one mesh is glb or gltf and the other is not: the axis that points up in the other (default: z). "
               "glTF prescribes y, and ply, obj, stl and drc nothing. With z the glTF mesh is turned, which the result "
               "tells: (x, y, z) becomes (x, -z, y), as it was before convert turned it. With y nothing is turned: "
               "for meshes that were written with --up y or --space index.");
  input.value("--memory-limit", "SIZE", flags.memory_limit, parse_size, kMemoryLimitText);
  const Group output(app, "Output");
  output.value("--max-distance", "D", flags.max_distance, parse_not_negative,
               "Exit with code 6 unless no point of either mesh is farther than this from the other, in the meshes' "
               "unit.");
  output.flag("--json", flags.json, "Report as JSON.");
}

void declare_bench(CLI::App& app, BenchFlags& flags) {
  declare_input(app, flags.input, "INPUT...",
                "What to extract from (default: demo:torus), or gpu-threads for the "
                "cost of a GPU's threads (Timokhin and Mikhaylyuk), each");
  const Group input(app, "Input");
  input.value("--sizes", "N,N,...", flags.sizes, parse_demo_sizes,
              "Samples along each axis of demo fields (default: 32,64,128,256).");
  input.value(
      "--coarser", "F,F,...", flags.coarser, parse_coarse_factors,
      "Of files besides the data themselves: one sample, their mean, for each F^3; powers of two (default: 2,4,8 "
      "where that leaves 8 samples along each axis). The data's own surface is the truth.");
  const Group surface(app, "Surface");
  surface.value("--iso", "V", flags.iso, parse_number,
                "The value whose surface is extracted (default: the demo field's own). Files need it.");
  surface.value("--methods", "M,M,...", flags.methods, parse_methods,
                fmt::format("Of {} (default: {}).", fmt::join(extract::method_ids(), " and "),
                            fmt::join(extract::method_ids(), ",")));
  declare_nan(surface, flags.nan);
  const Group output(app, "Output");
  output.value<std::string>("--csv", "FILE", flags.csv, parse_text, "Write the rows of the table as CSV.");
  output.value<std::string>("--json", "FILE", flags.json, parse_text, "Write everything as JSON.");
  output.value<std::string>("--plot", "FILE", flags.plot, parse_text,
                            "Draw error over run time with gnuplot, as .svg or .png.");
  const Group run(app, "Run");
  declare_backends(run, flags.backends, "cpu, and gpu where there is one that is not software");
  declare_device(run, flags.device);
  run.value("--threads", "N,N,...", flags.threads, parse_thread_counts,
            "Numbers of threads to compare, none above that of the machine (default: 1 and all).");
  run.value("--repeats", "N", flags.repeats, parse_repeats,
            "Times to run each setting after a warm-up; the median counts (default: 5).");
  declare_verbosity(run, flags.run);
}

void declare_stability(CLI::App& app, StabilityFlags& flags) {
  Group(app, "Input")
      .values<std::string>("--case", "NAME", flags.cases, parse_text,
                           "Run this case only; several times for several cases (default: all).");
  const Group output(app, "Output");
  output.flag("--list", flags.list, "List the cases, what is extreme about each, and run none.");
  output.flag("--json", flags.json, "Report as JSON.");
  const Group run(app, "Run");
  declare_backends(run, flags.backends, "cpu, and gpu where there is one");
  declare_device(run, flags.device);
  declare_run(app, flags.run);
}

// Of a command that says nothing but its results and errors.

void declare_devices(CLI::App& app, DevicesFlags& flags) {
  Group(app, "Output").flag("--json", flags.json, "Report as JSON, an array with one entry a device.");
  declare_quiet(app, flags.quiet);
}

CLI::App* add_command(CLI::App& app, const std::string& name, const std::string& description) {
  CLI::App* command = app.add_subcommand(name, description);
  command->allow_extras();  // the caller names what is unknown, with a suggestion
  return command;
}

}  // namespace

std::unique_ptr<CommandLine> declare_command_line() {
  auto line = std::make_unique<CommandLine>();
  CLI::App& app = line->app;
  app.name("isoextract");
  app.description("Extract isosurfaces from volumes and write them as meshes.");
  app.allow_extras();
  app.set_help_flag("-h,--help", "Show an overview and exit.")->group("Run");
  app.set_version_flag("--version", "isoextract " + std::string(version()), "Show the version and exit.")->group("Run");
  app.require_subcommand(1);

  line->convert = add_command(app, "convert", "Extract a surface and write it as a mesh. The default command.");
  ConvertFlags& convert = line->convert_flags;
  declare_input(*line->convert, convert.input, "INPUT", "The volume to convert");
  declare_convert_surface(*line->convert, convert);
  declare_frames(*line->convert, convert.batch);
  declare_placement(*line->convert, convert.placement);
  declare_output(*line->convert, convert);
  const Group convert_run(*line->convert, "Run");
  convert_run
      .choice("--error", convert.error,

              "Measure how far the mesh is from the isosurface of the data, interpolated linearly along each axis "
              "(the default) or smoothly; of demo fields also how far from the formula.")
      ->expected(0, 1);
  convert_run.choice("--backend", convert.backend,

                     "What extracts: the processor, a GPU, or a GPU where there is one that is not software (default: "
                     "cpu). The triangles are the same.");
  declare_device(convert_run, convert.device);
  convert_run.flag("--verify", convert.verify,
                   "Extract with the other backend as well, CPU or GPU, and compare triangle by triangle. Where they "
                   "differ, exit with code 6 and do not write the file.");
  convert_run.value<std::string>(
      "--config", "FILE", convert.config, parse_text,
      "Take options from a TOML file: keys are their long names without dashes, and input; an option that may be given "
      "several times takes a list, one without a value takes true. What the command line has as well wins over the "
      "file. Relative paths in it are relative to the current folder.");
  convert_run.flag("--explain", convert.explain, "Tell what was left out and why, with counts and times.");
  declare_run(*line->convert, convert.run);

  line->info = add_command(app, "info", "Show what a volume holds, and suggest an iso value.");
  declare_input(*line->info, line->info_flags.input, "INPUT...", "The volumes to look at, each");
  Group(*line->info, "Output")
      .flag("--json", line->info_flags.json, "Report as JSON, an array with one entry an input.");
  declare_run(*line->info, line->info_flags.run);

  line->verify =
      add_command(app, "verify", "Compare GPU and CPU, or a written mesh with its volume, triangle by triangle.");
  declare_verify(*line->verify, line->verify_flags);

  line->compare = add_command(app, "compare", "Compare two meshes: their topology, and the distances between them.");
  declare_compare(*line->compare, line->compare_flags);
  declare_run(*line->compare, line->compare_flags.run);
  line->bench = add_command(app, "bench", "Measure error against run time of all methods, and draw it.");
  declare_bench(*line->bench, line->bench_flags);

  line->stability = add_command(app, "stability", "Extract extreme fields with every method, and check every vertex.");
  declare_stability(*line->stability, line->stability_flags);

  line->merge = add_command(app, "merge", "Join the manifests of the shards of a batch, and check that all is there.");
  declare_merge(*line->merge, line->merge_flags);

  line->devices = add_command(app, "devices", "List the GPUs that can be used without a display.");
  declare_devices(*line->devices, line->devices_flags);

  line->help = add_command(app, "help", "Explain a command or a topic.");
  std::vector<Choice<std::string>> topics;
  for (const std::string& name : help_names()) topics.push_back({name, name});
  Group(*line->help, "Input").choice("TOPIC", line->help_topic, topics, "A command, a group of options, or a subject.");
  declare_quiet(*line->help, line->quiet);

  line->generate = add_command(app, "generate", "Write the man page or a shell completion to stdout.");
  Group(*line->generate, "Input")
      .choice("DOCUMENT", line->document,
              {{"man", Document::man}, {"bash", Document::bash}, {"zsh", Document::zsh}, {"fish", Document::fish}},
              "The man page, or the completion script of a shell.");
  declare_quiet(*line->generate, line->quiet);
  return line;
}

}  // namespace isoextract::cli

#include "cli/plan.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/task_arena.h>

#include "batch/output_names.hpp"
#include "cli/packing_plan.hpp"
#include "cli/particle_plan.hpp"
#include "field/demo_field.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::cli {
namespace {

constexpr std::string_view kIsoPattern = "{iso}";

tl::unexpected<Error> usage(std::string message, Hint hint = {}) {
  return fail(ErrorKind::usage, std::move(message), std::move(hint));
}

bool is_gltf(meshes::MeshFormat format) {
  return format == meshes::MeshFormat::glb || format == meshes::MeshFormat::gltf;
}

MemoryBudget plan_memory(const std::optional<std::uint64_t>& limit) {
  return limit ? MemoryBudget(*limit) : MemoryBudget();
}

// Commands that can work through all volumes ask the flags before they come here.
Result<std::optional<std::int64_t>> plan_one_volume(const InputFlags& flags) {
  if (!flags.volume) return std::nullopt;
  if (const auto* number = std::get_if<std::int64_t>(&*flags.volume)) return *number;
  return usage("--volume all stands for several volumes, where one is needed",
               "give the number of one; 'isoextract info INPUT' tells how many there are");
}

Result<meshes::MeshFormat> format_of_path(const std::string& path, std::string hint) {
  if (const auto format = meshes::mesh_format_by_path(path)) return *format;
  std::vector<std::string_view> names;
  for (const meshes::MeshFormatInfo& info : meshes::mesh_formats()) names.push_back(info.name);
  return usage(fmt::format("{}: expected an extension of {}", path, fmt::join(names, ", ")), std::move(hint));
}

bool is_folder(const std::string& path) {
  std::error_code none;
  return path.ends_with('/') || std::filesystem::is_directory(path, none);
}

Result<meshes::MeshFormat> plan_format(const ConvertFlags& flags) {
  if (flags.format) return *flags.format;
  if (!flags.output || is_folder(*flags.output)) return meshes::MeshFormat::glb;
  if (*flags.output == "-") return usage("-o - needs --format", "for example --format ply");
  return format_of_path(*flags.output, "choose the format with --format");
}

convert::SurfaceOptions plan_surface(const SurfaceFlags& flags) {
  convert::SurfaceOptions surface;
  surface.method = flags.method.value_or(surface.method);
  surface.nan = flags.nan.value_or(surface.nan);
  surface.cap = flags.cap;
  return surface;
}

Result<convert::Placement> plan_placement(const PlacementFlags& flags, meshes::MeshFormat format,
                                          std::vector<std::string>& notes) {
  convert::Placement placement;
  placement.space = flags.space.value_or(convert::Space::world);
  placement.up = flags.up.value_or(convert::UpAxis::z);
  if (placement.space == convert::Space::index) {
    const std::string_view other = flags.up ? "--up" : flags.scale ? "--scale" : flags.unit ? "--unit" : "";
    if (!other.empty()) {
      return usage(fmt::format("--space index gives voxel coordinates, which {} cannot change", other),
                   fmt::format("leave out {} or --space index", other));
    }
    return placement;
  }
  if (flags.scale && flags.unit) return usage("--scale and --unit exclude each other");
  placement.turn_z_up_to_y_up = is_gltf(format) && placement.up == convert::UpAxis::z;
  if (flags.up && !is_gltf(format)) {
    notes.push_back(fmt::format("--up changes nothing: {} prescribes no up axis and keeps the input's axes",
                                meshes::mesh_format_info(format).name));
  }
  if (flags.scale) placement.scale = *flags.scale;
  if (flags.unit) {
    placement.scale = flags.unit->metres;
    placement.unit = flags.unit->name;
  }
  return placement;
}

Result<convert::Normals> plan_normals(const ConvertFlags& flags, meshes::MeshFormat format) {
  if (format == meshes::MeshFormat::stl) {
    if (flags.normals.value_or(convert::Normals::flat) == convert::Normals::flat) return convert::Normals::flat;
    return usage(fmt::format("--normals {} does not go with stl, which always stores one normal a triangle",
                             word_of(*flags.normals)),
                 "leave out --normals, or choose another format");
  }
  const extract::MethodInfo& method = extract::method_info(plan_surface(flags.surface).method);
  if (!method.traits.gradient_normals) {
    if (flags.normals != convert::Normals::smooth) return flags.normals.value_or(convert::Normals::none);
    return usage(fmt::format("--normals smooth: {}", extract::why_no_gradient_normals(method)),
                 "--normals flat needs none");
  }
  return flags.normals.value_or(is_gltf(format) ? convert::Normals::smooth : convert::Normals::none);
}

std::string with_iso(std::string path, double iso) {
  const std::string text = fmt::format("{}", iso);
  for (std::size_t at = path.find(kIsoPattern); at != std::string::npos; at = path.find(kIsoPattern, at)) {
    path.replace(at, kIsoPattern.size(), text);
    at += text.size();
  }
  return path;
}

// Some, and each once.
Result<void> check_isos(const std::vector<double>& isos, const std::string& input) {
  if (isos.empty()) {
    return usage("--iso V is missing: the value whose surface is extracted",
                 fmt::format("'isoextract info {}' shows the values and suggests one", shell_quoted(input)));
  }
  std::vector<double> sorted = isos;
  std::sort(sorted.begin(), sorted.end());
  const auto repeated = std::adjacent_find(sorted.begin(), sorted.end());
  if (repeated != sorted.end()) return usage(fmt::format("--iso {} was given twice", *repeated));
  return {};
}

std::string output_path(const ConvertFlags& flags, const std::string& input, const meshes::MeshFormatInfo& format) {
  return flags.output ? *flags.output : fmt::format("{}.{}", batch::stem_of(input), format.name);
}

Result<std::vector<convert::OutputFileJob>> plan_outputs(const ConvertFlags& flags,
                                                         const meshes::MeshFormatInfo& format) {
  const std::string path = output_path(flags, flags.input.inputs.front(), format);
  if (path.empty()) return usage("-o needs the name of a file");
  if (!flags.output && files::is_standard_input(flags.input.inputs.front())) {
    return usage("an input from stdin has no name that the mesh could have", "give -o FILE, or -o - for stdout");
  }
  if (path == "-" && !format.can_stream) {
    return usage(fmt::format("{} cannot be written to stdout", format.name), format.format == meshes::MeshFormat::gltf
                                                                                 ? "it is two files; use --format glb"
                                                                                 : "give a file with -o");
  }
  if (path.find(kIsoPattern) != std::string::npos) {
    std::vector<convert::OutputFileJob> jobs;
    for (const double iso : flags.isos) jobs.push_back({with_iso(path, iso), {iso}});
    return jobs;
  }
  if (flags.isos.size() > 1 && !format.holds_several_meshes) {
    return usage(
        fmt::format("one {} file holds one surface, and {} iso values were given", format.name, flags.isos.size()),
        fmt::format("write one file each with -o {}_{{iso}}.{}, or all into a glb",
                    batch::stem_of(flags.input.inputs.front()), format.name));
  }
  return std::vector<convert::OutputFileJob>{{path, flags.isos}};
}

}  // namespace

Result<volumes::ReadOptions> plan_read(const InputFlags& flags) {
  for (const std::string& input : flags.inputs) {
    if (input.empty()) return usage("INPUT is empty");
  }
  if (std::ranges::count_if(flags.inputs, files::is_standard_input) > 1) {
    return usage("'-' was given twice, and stdin can be read once");
  }
  const auto volume = plan_one_volume(flags);
  if (!volume) return tl::unexpected(volume.error());
  volumes::ReadOptions read;
  read.volume = *volume;
  read.format = flags.format;
  read.grid = flags.grid;
  read.spacing = flags.spacing;
  read.origin = flags.origin;
  read.kind = flags.inside;
  if (flags.dims) {
    volumes::RawLayout raw;
    raw.dims = *flags.dims;
    raw.type = flags.dtype.value_or(raw.type);
    raw.endian = flags.endian.value_or(raw.endian);
    raw.skip = flags.skip.value_or(raw.skip);
    read.raw = raw;
  } else if (flags.dtype || flags.endian || flags.skip) {
    return usage(fmt::format("{} describes a raw file, which needs --dims as well", flags.dtype    ? "--dtype"
                                                                                    : flags.endian ? "--endian"
                                                                                                   : "--skip"),
                 "give --dims NX,NY,NZ");
  }
  return read;
}

gpu::GpuChoice plan_gpu(const DeviceFlags& flags) {
  gpu::GpuChoice gpu;
  if (flags.device) gpu.device = *flags.device;
  gpu.memory_bytes = flags.gpu_memory;
  return gpu;
}

std::vector<NamedBackend> plan_backends(std::vector<NamedBackend> backends, const DeviceFlags& flags) {
  for (NamedBackend& backend : backends) {
    if (flags.device) backend.gpu.device = *flags.device;
    backend.gpu.memory_bytes = flags.gpu_memory;
  }
  return backends;
}

Result<Verbosity> plan_verbosity(const RunFlags& flags) {
  if (flags.quiet && flags.verbose) return usage("--quiet and --verbose exclude each other");
  return flags.quiet ? Verbosity::quiet : flags.verbose ? Verbosity::verbose : Verbosity::normal;
}

Result<ConvertPlan> plan_conversion(const ConvertFlags& flags, const std::string& input,
                                    const std::vector<double>& isos) {
  if (flags.report && (flags.report->empty() || *flags.report == "-")) {
    return usage(fmt::format("--report needs the name of a file, found '{}'", *flags.report));
  }
  if (auto checked = check_isos(isos, input); !checked) return tl::unexpected(checked.error());
  const auto verbosity = plan_verbosity(flags.run);
  if (!verbosity) return tl::unexpected(verbosity.error());
  if (flags.explain && flags.run.quiet) return usage("--quiet and --explain exclude each other");

  ConvertPlan plan;
  plan.verbosity = *verbosity;
  plan.threads = flags.run.threads;
  convert::ConversionJob& job = plan.job;
  auto read = plan_read(flags.input);
  if (!read) return tl::unexpected(read.error());
  job.source.read = std::move(*read);
  auto particles = plan_particles(flags.particles, flags.surface.nan);
  if (!particles) return tl::unexpected(particles.error());
  job.source.particles = std::move(*particles);
  plan.memory = plan_memory(flags.input.memory_limit);

  const auto format = plan_format(flags);
  if (!format) return tl::unexpected(format.error());
  const meshes::MeshFormatInfo& info = meshes::mesh_format_info(*format);
  if (flags.output && meshes::mesh_format_by_path(*flags.output).value_or(*format) != *format) {
    plan.notes.push_back(
        fmt::format("{}: its format is {}, as --format says, and not what its name says", *flags.output, info.name));
  }
  if (flags.ascii && !info.has_ascii) {
    return usage(fmt::format("--ascii does not go with {}", info.name), "ply and stl can be written as text");
  }
  if (auto fine = check_attributes(flags.particles, info); !fine) return tl::unexpected(fine.error());
  const auto normals = plan_normals(flags, *format);
  if (!normals) return tl::unexpected(normals.error());
  job.normals = *normals;
  job.format = *format;
  job.ascii = flags.ascii;
  const auto packing = plan_packing(flags, *format);
  if (!packing) return tl::unexpected(packing.error());
  job.packing = *packing;

  auto placement = plan_placement(flags.placement, *format, plan.notes);
  if (!placement) return tl::unexpected(placement.error());
  job.source.placement = std::move(*placement);

  job.surface = plan_surface(flags.surface);
  job.verify = flags.verify;
  job.backend = {flags.backend.value_or(convert::Backend::cpu), plan_gpu(flags.device)};
  if (job.backend.backend == convert::Backend::cpu && !job.verify && (flags.device.device || flags.device.gpu_memory)) {
    return usage(fmt::format("{} is about the GPU, which --backend cpu does not use",
                             flags.device.device ? "--device" : "--gpu-memory"),
                 "give --backend gpu or --backend auto");
  }
  job.source.roi = flags.surface.roi;
  job.source.resolution = flags.surface.resolution;
  job.simplify = flags.simplify;
  job.empty = flags.empty.value_or(job.empty);
  job.error = flags.error;
  plan.explain = flags.explain;
  plan.report = flags.report;
  return plan;
}

Result<ConvertPlan> plan_convert(const ConvertFlags& given) {
  const std::vector<std::string>& inputs = given.input.inputs;
  if (inputs.empty()) return usage("no INPUT was given", "isoextract INPUT --iso V -o OUT.glb");
  ConvertFlags flags = given;
  auto note = take_iso_of_method(flags, inputs.front());
  if (!note) return tl::unexpected(note.error());
  auto plan = plan_conversion(flags, inputs.front(), flags.isos);
  if (!plan) return plan;
  if (!note->empty()) plan->notes.push_back(std::move(*note));
  plan->job.source.input = inputs.front();
  auto outputs = plan_outputs(flags, meshes::mesh_format_info(plan->job.format));
  if (!outputs) return tl::unexpected(outputs.error());
  plan->job.outputs = std::move(*outputs);
  return plan;
}

Result<PictureFormat> picture_format_of(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension();
  if (extension == ".svg") return PictureFormat::svg;
  if (extension == ".png") return PictureFormat::png;
  return usage(fmt::format("{}: expected a name that ends in .svg or .png", path));
}

std::vector<convert::ConversionJob> plan_files(const ConvertFlags& flags) {
  std::vector<std::string> inputs = flags.input.inputs;
  if (inputs.empty()) inputs.emplace_back();
  const auto by_name = flags.output ? meshes::mesh_format_by_path(*flags.output) : std::nullopt;
  const meshes::MeshFormat format = flags.format.value_or(by_name.value_or(meshes::MeshFormat::glb));
  std::vector<convert::ConversionJob> jobs;
  for (const std::string& input : inputs) {
    convert::ConversionJob& job = jobs.emplace_back();
    job.source.input = input;
    job.source.read = plan_read(flags.input).value_or(volumes::ReadOptions{});
    job.format = format;
    const std::string path = output_path(flags, input, meshes::mesh_format_info(format));
    job.outputs.push_back({path, {}});
    for (const double iso : flags.isos) job.outputs.push_back({with_iso(path, iso), {iso}});
  }
  return jobs;
}

Result<InfoPlan> plan_info(const InfoFlags& flags, const CLI::App& command) {
  if (flags.input.inputs.empty()) return usage("no INPUT was given", "isoextract info INPUT");
  InfoPlan plan;
  auto read = plan_read(flags.input);
  if (!read) return tl::unexpected(read.error());
  auto particles = plan_particles(flags.particles, std::nullopt);
  if (!particles) return tl::unexpected(particles.error());
  plan.inputs = flags.input.inputs;
  plan.read = std::move(*read);
  plan.particles = std::move(*particles);
  plan.memory = plan_memory(flags.input.memory_limit);
  plan.json = flags.json;
  for (const char* group : {"Input", "Particles"}) {
    for (const CLI::Option* option : options_in_group(command, group)) {
      if (option->get_positional() || option->count() == 0) continue;
      plan.input_arguments.push_back(option->get_name());
      plan.input_arguments.push_back(shell_quoted(option->results().front()));
    }
  }
  return plan;
}

Result<VerifyPlan> plan_verify(const VerifyFlags& flags) {
  if (flags.input.inputs.empty()) return usage("no INPUT was given", "isoextract verify INPUT --iso V [MESH]");
  VerifyPlan plan;
  plan.source.input = flags.input.inputs.front();
  plan.mesh = flags.mesh;
  if (auto checked = check_isos(flags.isos, plan.source.input); !checked) return tl::unexpected(checked.error());
  plan.isos = flags.isos;
  auto read = plan_read(flags.input);
  if (!read) return tl::unexpected(read.error());
  plan.source.read = std::move(*read);
  auto particles = plan_particles(flags.particles, flags.surface.nan);
  if (!particles) return tl::unexpected(particles.error());
  plan.source.particles = std::move(*particles);
  plan.memory = plan_memory(flags.input.memory_limit);
  meshes::MeshFormat format = meshes::MeshFormat::glb;  // backends are compared where the default output would be
  if (plan.mesh) {
    const auto given = format_of_path(*plan.mesh, "MESH is a mesh that isoextract wrote");
    if (!given) return tl::unexpected(given.error());
    format = *given;
  }
  plan.float32_world = format == meshes::MeshFormat::stl || format == meshes::MeshFormat::drc;
  auto placement = plan_placement(flags.placement, format, plan.notes);
  if (!placement) return tl::unexpected(placement.error());
  plan.source.placement = std::move(*placement);
  plan.source.roi = flags.surface.roi;
  plan.source.resolution = flags.surface.resolution;
  plan.surface = plan_surface(flags.surface);
  plan.gpu = plan_gpu(flags.device);
  plan.json = flags.json;
  return plan;
}

Result<ComparePlan> plan_compare(const CompareFlags& flags) {
  if (flags.meshes.size() != 2) {
    return usage(fmt::format("compare takes two meshes, found {}{}{}", flags.meshes.size(),
                             flags.meshes.empty() ? "" : ": ", fmt::join(flags.meshes, ", ")),
                 "isoextract compare A.glb B.glb");
  }
  if (std::ranges::any_of(flags.meshes, files::is_standard_input)) {
    return usage("the meshes to compare cannot be read from stdin", "give the paths of files");
  }
  ComparePlan plan;
  plan.meshes = {flags.meshes[0], flags.meshes[1]};
  plan.up = flags.up;
  plan.max_distance = flags.max_distance;
  plan.memory = plan_memory(flags.memory_limit);
  plan.json = flags.json;
  return plan;
}

static Result<BenchPlan> plan_gpu_threads(const BenchFlags& flags, BenchPlan plan) {
  const std::array<std::pair<bool, std::string_view>, 8> others{{{flags.iso.has_value(), "--iso"},
                                                                 {flags.coarser.has_value(), "--coarser"},
                                                                 {flags.methods.has_value(), "--methods"},
                                                                 {flags.nan.has_value(), "--nan"},
                                                                 {flags.backends.has_value(), "--backends"},
                                                                 {flags.threads.has_value(), "--threads"},
                                                                 {flags.csv.has_value(), "--csv"},
                                                                 {flags.plot.has_value(), "--plot"}}};
  for (const auto& [given, name] : others) {
    if (given) return usage(fmt::format("bench gpu-threads extracts no surface: leave out {}", name));
  }
  plan.gpu_threads = true;
  plan.gpu = plan_gpu(flags.device);
  plan.sizes = flags.sizes.value_or(std::vector<int>{32, 64, 128, 256});
  plan.json = flags.json;
  return plan;
}

Result<BenchPlan> plan_bench(const BenchFlags& flags) {
  BenchPlan plan;
  auto read = plan_read(flags.input);
  if (!read) return tl::unexpected(read.error());
  plan.read = std::move(*read);
  plan.memory = plan_memory(flags.input.memory_limit);
  plan.inputs = flags.input.inputs;
  plan.options.repeats = flags.repeats.value_or(plan.options.repeats);
  if (std::ranges::find(plan.inputs, "gpu-threads") != plan.inputs.end()) {
    if (plan.inputs.size() == 1) return plan_gpu_threads(flags, std::move(plan));
    return usage("bench gpu-threads extracts no surface, so it takes no other input beside it", "run bench twice");
  }
  if (plan.inputs.empty()) plan.inputs.push_back(fmt::format("{}torus", field::kDemoPrefix));
  const auto is_demo = [](const std::string& input) { return input.starts_with(field::kDemoPrefix); };
  const auto file = std::ranges::find_if_not(plan.inputs, is_demo);
  const auto demo = std::ranges::find_if(plan.inputs, is_demo);
  if (file != plan.inputs.end() && !flags.iso) {
    std::error_code unknown;
    if (!files::is_standard_input(*file) && !std::filesystem::exists(*file, unknown)) {
      return fail(ErrorKind::input, fmt::format("{}: there is no such file", *file));
    }
    return usage(fmt::format("{}: a file needs --iso V, the value whose surface is extracted", *file),
                 fmt::format("'isoextract info {}' shows the values and suggests one", shell_quoted(*file)));
  }
  if (flags.sizes && demo == plan.inputs.end()) {
    return usage("--sizes are those of demo fields", "files have their own size, and coarser ones with --coarser");
  }
  if (flags.coarser && file == plan.inputs.end()) {
    return usage("--coarser is for files", "demo fields are made in the --sizes that are asked for");
  }
  for (const std::string& input : plan.inputs) {
    if (!is_demo(input)) continue;
    const auto spec = field::parse_demo_spec(input);
    if (!spec) return tl::unexpected(spec.error());
    if (input.find('?') != std::string::npos) {
      return usage(
          fmt::format("{}: expected a demo field without settings, found '{}'", input, input.substr(input.find('?'))),
          fmt::format("bench measures several sizes: {}{} --sizes {}", field::kDemoPrefix, spec->name, spec->size));
    }
  }
  plan.iso = flags.iso;
  plan.sizes = flags.sizes.value_or(std::vector<int>{32, 64, 128, 256});
  plan.coarser = flags.coarser.value_or(std::vector<int>{});
  std::ranges::reverse(plan.coarser);
  plan.options.nan = flags.nan.value_or(extract::NanPolicy::error);
  if (flags.methods) {
    for (const extract::Method method : *flags.methods) plan.options.methods.push_back(extract::method_info(method));
  } else {
    plan.options.methods.assign(extract::kMethods.begin(), extract::kMethods.end());
  }
  if (flags.backends) plan.backends = plan_backends(*flags.backends, flags.device);
  plan.gpu = plan_gpu(flags.device);
  plan.options.threads = flags.threads.value_or(std::vector<int>{1});
  if (auto checked = measure::check_thread_counts(plan.options.threads); !checked) {
    return usage("--threads: " + checked.error().message, checked.error().hint);
  }
  const int all = tbb::this_task_arena::max_concurrency();
  if (!flags.threads && all > 1) plan.options.threads.push_back(all);

  for (const auto& path : {flags.csv, flags.json, flags.plot}) {
    if (path && (path->empty() || *path == "-")) {
      return usage("--csv, --json and --plot need the name of a file", "the table goes to stdout");
    }
  }
  plan.csv = flags.csv;
  plan.json = flags.json;
  plan.plot = flags.plot;
  if (plan.plot) {
    const auto picture = picture_format_of(*plan.plot);
    if (!picture) return tl::unexpected(picture.error());
    plan.picture = *picture;
  }
  return plan;
}

}  // namespace isoextract::cli

#include "cli/options.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/version.hpp"
#include "cli/check_options.hpp"
#include "cli/convert_options.hpp"
#include "cli/help_topics.hpp"
#include "cli/render_options.hpp"
#include "cli/shared_options.hpp"
#include "cli/simulate_options.hpp"
#include "field/demo_field.hpp"

namespace isoextract::cli {
namespace {

// As one word, for --methods.
std::string following_method_ids() {
  std::vector<std::string_view> ids;
  for (const extract::MethodInfo& method : extract::following_methods()) ids.push_back(method.id);
  return fmt::format("{}", fmt::join(ids, ","));
}

void declare_merge(CLI::App& app, MergeFlags& flags) {
  Group(app, "Input")
      .value<std::string>("FOLDER", "FOLDER", flags.folder, parse_text,
                          "The folder of the outputs, where the manifests of the shards are.");
  declare_quiet(app, flags.quiet);
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
                fmt::format("Of {} (default: {}).", fmt::join(extract::method_ids(), ", "), following_method_ids()));
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
  app.description("Extract isosurfaces from volumes and particles as meshes.");
  app.allow_extras();
  app.set_help_flag("-h,--help", "Show an overview and exit.")->group("Run");
  app.set_version_flag("--version", "isoextract " + std::string(version()), "Show the version and exit.")->group("Run");
  app.require_subcommand(1);

  line->convert = add_command(app, "convert", "Extract a surface and write it as a mesh. The default command.");
  declare_convert(*line->convert, line->convert_flags);

  line->info = add_command(app, "info", "Show what a volume or particles hold, and suggest an iso value.");
  declare_input(*line->info, line->info_flags.input, "INPUT...",
                "The volumes or particles to look at, or patterns and folders of a sequence, each");
  declare_frame_range(Group(*line->info, "Input"), line->info_flags.frames,
                      "Frames of a sequence to look at, such as 1-240x20 (default: all).");
  declare_particles(*line->info, line->info_flags.particles);
  Group(*line->info, "Output")
      .flag("--json", line->info_flags.json, "Report as JSON, an array with one entry an input.");
  declare_run(*line->info, line->info_flags.run);

  line->verify =
      add_command(app, "verify", "Compare GPU and CPU, or a written mesh with its volume, triangle by triangle.");
  declare_verify(*line->verify, line->verify_flags);

  line->compare = add_command(app, "compare", "Compare two meshes: their topology, and the distances between them.");
  declare_compare(*line->compare, line->compare_flags);
  declare_run(*line->compare, line->compare_flags.run);

  line->check = add_command(app, "check", "Say what is wrong with a mesh, for printing, engines and solvers.");
  declare_check(*line->check, line->check_flags);

  line->render = add_command(app, "render", "Draw volumes, surfaces and meshes as pictures, as PNG or OpenEXR.");
  declare_render(*line->render, line->render_flags);

  line->bench = add_command(app, "bench", "Measure error against run time of all methods, and draw it.");
  declare_bench(*line->bench, line->bench_flags);

  line->stability = add_command(app, "stability", "Extract extreme fields with every method, and check every vertex.");
  declare_stability(*line->stability, line->stability_flags);

  line->merge = add_command(app, "merge", "Join the manifests of the shards of a batch, and check that all is there.");
  declare_merge(*line->merge, line->merge_flags);

  line->devices = add_command(app, "devices", "List the GPUs that can be used without a display.");
  declare_devices(*line->devices, line->devices_flags);

  line->simulate =
      add_command(app, "simulate", "Simulate what surfaces can be extracted from, and write it as a sequence.");
  declare_simulate(*line);

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

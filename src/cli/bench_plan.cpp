#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "cli/plan.hpp"
#include "cli/plan_parts.hpp"
#include "field/demo_field.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::cli {

Result<PictureFormat> picture_format_of(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension();
  if (extension == ".svg") return PictureFormat::svg;
  if (extension == ".png") return PictureFormat::png;
  return refuse_usage(fmt::format("{}: expected a name that ends in .svg or .png", path));
}

static Result<BenchPlan> plan_gpu_threads(const BenchFlags& flags, BenchPlan plan) {
  TRY(flags.refuse(About::extraction, "bench gpu-threads extracts no surface: leave out {}"));
  plan.gpu_threads = true;
  plan.gpu = plan_gpu(flags.device);
  plan.sizes = flags.sizes.value_or(std::vector<int>{32, 64, 128, 256});
  plan.json = flags.json;
  return plan;
}

Result<BenchPlan> plan_bench(const BenchFlags& flags) {
  BenchPlan plan;
  TRY(refuse_away_from_zero(flags.input, "bench"));
  TRY(refuse_several_grids(flags.input, "bench"));
  plan.read = TRY(plan_read(flags.input));
  plan.memory = plan_memory(flags.input.memory_limit);
  plan.inputs = flags.input.inputs;
  plan.options.repeats = flags.repeats.value_or(plan.options.repeats);
  if (std::ranges::find(plan.inputs, "gpu-threads") != plan.inputs.end()) {
    if (plan.inputs.size() == 1) return plan_gpu_threads(flags, std::move(plan));
    return refuse_usage("bench gpu-threads extracts no surface and takes no other input",
                        "run bench once for gpu-threads and once for the inputs");
  }
  if (plan.inputs.empty()) plan.inputs.push_back(fmt::format("{}torus", field::kDemoPrefix));
  const auto is_demo = [](const std::string& input) { return input.starts_with(field::kDemoPrefix); };
  const auto file = std::ranges::find_if_not(plan.inputs, is_demo);
  const auto demo = std::ranges::find_if(plan.inputs, is_demo);
  if (file != plan.inputs.end() && !flags.iso) {
    std::error_code unknown;
    if (!files::is_standard_input(*file) && !std::filesystem::exists(*file, unknown)) {
      return fail(ErrorCode::input, fmt::format("{}: there is no such file", *file));
    }
    return refuse_usage(
        fmt::format("{}: a file needs --iso V, the iso value of the surface", *file),
        fmt::format("'isoextract info {}' shows the range of values and suggests iso values", shell_quoted(*file)));
  }
  if (flags.sizes && demo == plan.inputs.end()) {
    return refuse_usage("--sizes sets the sizes of demo fields, but all inputs are files",
                        "files keep their own size; --coarser measures coarser grids as well");
  }
  if (flags.coarser && file == plan.inputs.end()) {
    return refuse_usage("--coarser applies to files, but all inputs are demo fields",
                        "choose the sizes of demo fields with --sizes");
  }
  for (const std::string& input : plan.inputs) {
    if (!is_demo(input)) continue;
    const auto spec = TRY(field::parse_demo_spec(input));
    if (input.find('?') != std::string::npos) {
      return refuse_usage(
          fmt::format("{}: expected a demo field without settings, found '{}'", input, input.substr(input.find('?'))),
          fmt::format("give the size as an option: {}{} --sizes {}", field::kDemoPrefix, spec.name, spec.size));
    }
  }
  plan.iso = flags.iso;
  plan.sizes = flags.sizes.value_or(std::vector<int>{32, 64, 128, 256});
  plan.coarser = flags.coarser.value_or(std::vector<int>{});
  std::ranges::reverse(plan.coarser);
  plan.options.nan = flags.nan.value_or(default_nan_policy(flags.input));
  if (flags.methods) {
    for (const extract::Method method : *flags.methods) plan.options.methods.push_back(extract::method_info(method));
  } else {
    plan.options.methods = extract::interpolant_methods();
  }
  if (flags.backends) plan.backends = plan_backends(*flags.backends, flags.device);
  plan.gpu = plan_gpu(flags.device);
  plan.options.threads = flags.threads.value_or(std::vector<int>{1});
  if (auto checked = bench::check_thread_counts(plan.options.threads); !checked) {
    return refuse_usage("--threads: " + checked.error().message, checked.error().hint);
  }
  const int all = tbb::this_task_arena::max_concurrency();
  if (!flags.threads && all > 1) plan.options.threads.push_back(all);

  for (const auto& path : {flags.csv, flags.json, flags.plot}) {
    if (path && (path->empty() || *path == "-")) {
      return refuse_usage("--csv, --json and --plot need the name of a file",
                          "give a file name; stdout shows the table in any case");
    }
  }
  plan.csv = flags.csv;
  plan.json = flags.json;
  plan.plot = flags.plot;
  if (plan.plot) {
    plan.picture = TRY(picture_format_of(*plan.plot));
  }
  return plan;
}

}  // namespace isoextract::cli

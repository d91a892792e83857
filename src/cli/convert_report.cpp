#include "cli/convert_report.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "cli/mesh_error.hpp"
#include "files/output_file.hpp"
#include "measure/benchmark.hpp"

namespace isoextract::cli {
namespace {

std::string nan_word(extract::NanPolicy policy) {
  switch (policy) {
    case extract::NanPolicy::error: return "error";
    case extract::NanPolicy::outside: return "outside";
    case extract::NanPolicy::hole: break;
  }
  return "hole";
}

std::string empty_word(EmptyPolicy policy) {
  switch (policy) {
    case EmptyPolicy::error: return "error";
    case EmptyPolicy::skip: return "skip";
    case EmptyPolicy::write: break;
  }
  return "write";
}

convert::ResolvedOptions resolved_options(const ConvertPlan& plan) {
  convert::ResolvedOptions options;
  options.method = measure::method_name(plan.extract.method);
  for (const OutputJob& job : plan.jobs) options.isos.insert(options.isos.end(), job.isos.begin(), job.isos.end());
  options.normals = plan.extract.smooth_normals ? "smooth" : plan.write.flat_normals ? "flat" : "none";
  options.nan = nan_word(plan.extract.nan);
  options.empty = empty_word(plan.empty);
  options.cap = plan.extract.cap;
  options.roi = plan.roi;
  options.resolution = plan.resolution;
  options.space = plan.placement.space == Space::index ? "index" : "world";
  options.up = plan.placement.up == UpAxis::y ? "y" : "z";
  options.turned_to_y_up = plan.placement.turn_z_up_to_y_up;
  options.scale = plan.placement.scale;
  options.unit = plan.placement.unit;
  options.format = meshes::mesh_format_info(plan.write.format).name;
  options.ascii = plan.write.ascii;
  if (plan.simplify) {
    options.simplify = fmt::format("{}{}", plan.simplify->distance, plan.simplify->in_world_units ? "world" : "voxel");
  }
  if (plan.error) options.error = interpolation_name(*plan.error);
  options.verify = plan.verify;
  options.memory_limit = plan.limits.memory_bytes;
  return options;
}

int thread_count() {
  const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return std::min(static_cast<int>(std::min<std::size_t>(allowed, 1 << 16)), tbb::this_task_arena::max_concurrency());
}

}  // namespace

convert::ConversionReport begin_report(const ConvertPlan& plan) {
  convert::ConversionReport report;
  report.arguments = plan.arguments;
  report.options = resolved_options(plan);
  report.backend = backend_name(plan.backend.backend);
  report.threads = thread_count();
  return report;
}

Result<void> write_report(const std::string& path, const convert::ConversionReport& report) {
  auto file = files::OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  if (auto written = file->write(convert::json_text(json_of(report))); !written) return written;
  return file->commit();
}

}  // namespace isoextract::cli

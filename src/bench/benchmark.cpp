#include "bench/benchmark.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "accuracy/field_error.hpp"
#include "accuracy/index_mesh.hpp"
#include "base/median.hpp"
#include "base/stopwatch.hpp"
#include "bench/detail/reference_size.hpp"
#include "field/coarsen.hpp"
#include "field/demo_field.hpp"
#include "field/statistics.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"

namespace isoextract::bench {
namespace {

// Smaller relative errors are float32 rounding and follow no order.
constexpr double kRounding = 1e-7;

extract::ExtractOptions extract_options(const field::ScalarField& field, extract::Method method,
                                        const BenchOptions& options) {
  extract::ExtractOptions extract;
  extract.method = method;
  extract.iso = options.iso;
  extract.nan = options.nan;
  extract.output_from_index = field.index_to_world;
  return extract;
}

double spacing_of(const field::ScalarField& field) { return std::cbrt(std::abs(field.index_to_world.determinant())); }

std::string size_text(const field::ScalarField& field) {
  const glm::i64vec3 dims = field.extents().dims();
  return dims.x == dims.y && dims.y == dims.z ? fmt::format("{}", dims.x)
                                              : fmt::format("{}x{}x{}", dims.x, dims.y, dims.z);
}

std::uint64_t cells_of(const field::ScalarField& field) {
  const glm::i64vec3 cells = glm::max(field.extents().dims() - glm::i64vec3(1), glm::i64vec3(0));
  return static_cast<std::uint64_t>(cells.x) * static_cast<std::uint64_t>(cells.y) *
         static_cast<std::uint64_t>(cells.z);
}

// One method on one backend.
struct Contestant {
  extract::MethodInfo method;
  BenchBackend backend;

  [[nodiscard]] bool is(const BenchRow& row) const {
    return row.method == method.method && row.backend == backend.name;
  }
};

std::vector<Contestant> contestants(const BenchOptions& options) {
  std::vector<Contestant> all;
  for (const extract::MethodInfo& method : options.methods) {
    for (const BenchBackend& backend : options.backends) {
      if (backend.runs(method.method)) all.push_back({method, backend});
    }
  }
  return all;
}

// One contestant with one number of threads at one resolution.
struct Trial {
  Contestant contestant;
  int threads;
  std::uint64_t triangles = 0;
  std::vector<double> seconds;
  std::vector<extract::ExtractStats> stats;  // statistics of the same runs
};

Result<void> run_once(const field::ScalarField& field, const BenchOptions& options, bool timed, Trial& trial,
                      const Context& context) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(trial.threads));
  const Stopwatch watch;
  const auto& [method, backend] = trial.contestant;
  const auto extraction = backend.extractor->extract(field, extract_options(field, method.method, options), context);
  const double seconds = watch.elapsed().wall_seconds;
  if (!extraction) return tl::unexpected(extraction.error());
  trial.triangles = extraction->mesh.triangles.size();
  if (timed) {
    trial.seconds.push_back(seconds);
    trial.stats.push_back(extraction->stats);
  }
  return {};
}

std::optional<BenchDeviceTimes> device_times(const std::vector<extract::ExtractStats>& runs) {
  if (!runs.front().device) return std::nullopt;
  const auto median_of = [&](const auto& stage) {
    std::vector<double> seconds;
    for (const extract::ExtractStats& run : runs) seconds.push_back(stage(run).wall_seconds);
    return median(std::move(seconds));
  };
  BenchDeviceTimes times;
  times.upload = median_of([](const extract::ExtractStats& run) { return run.device->upload; });
  times.count = median_of([](const extract::ExtractStats& run) { return run.count; });
  times.capture = median_of([](const extract::ExtractStats& run) { return run.device->capture; });
  times.read_back = median_of([](const extract::ExtractStats& run) { return run.device->read_back; });
  times.weld = median_of([](const extract::ExtractStats& run) { return run.device->weld; });
  times.bytes_uploaded = runs.front().device->bytes_uploaded;
  times.bytes_captured = runs.front().device->bytes_captured;
  return times;
}

Result<std::vector<BenchRow>> time_level(const field::ScalarField& field, std::size_t level,
                                         const BenchOptions& options, const Context& context) {
  std::vector<Trial> trials;
  for (const Contestant& contestant : contestants(options)) {
    for (const int threads : options.threads) trials.push_back({contestant, threads, 0, {}, {}});
  }
  const auto rounds = static_cast<std::size_t>(options.repeats) + 1;
  context.progress().begin("timing", rounds * trials.size());
  const Context untold(context.memory());  // the progress bar shows rounds only
  for (std::size_t round = 0; round < rounds; ++round) {
    for (Trial& trial : trials) {
      TRY(run_once(field, options, round > 0, trial, untold));
      context.progress().advance(1);
      TRY(context.check());
    }
    std::ranges::reverse(trials);
  }
  if (rounds % 2 != 0) std::ranges::reverse(trials);
  std::vector<BenchRow> rows;
  for (Trial& trial : trials) {
    BenchRow row;
    row.level = level;
    row.method = trial.contestant.method.method;
    row.backend = trial.contestant.backend.name;
    row.threads = trial.threads;
    row.triangles = trial.triangles;
    row.min_seconds = std::ranges::min(trial.seconds);
    row.max_seconds = std::ranges::max(trial.seconds);
    row.median_seconds = median(trial.seconds);
    row.device = device_times(trial.stats);
    rows.push_back(std::move(row));
  }
  return rows;
}

// The mesh of one method and backend at one resolution, for measuring errors.
struct MeasuredMesh {
  const field::ScalarField& field;
  const extract::ExtractOptions& extracted;
  const mesh::Mesh& mesh;
  double volume;  // of the capped mesh
};

// `in_finer`: finer data do have a surface.
tl::unexpected<Error> no_surface(const field::ScalarField& field, double iso, bool in_finer) {
  const field::FieldStatistics statistics = field::measure_statistics(field);
  if (statistics.samples == 0) {
    return fail(ErrorCode::input, fmt::format("{}: no surface: the grid stores no finite sample", field.source));
  }
  const field::IsoSuggestion other = field::suggest_iso(field, statistics);
  return fail(
      ErrorCode::input,
      fmt::format("{}: no surface at iso {} with {} samples along an axis; the values range from {:.6g} to {:.6g}",
                  field.source, iso, size_text(field), statistics.min, statistics.max),
      in_finer ? Hint{{Remedy::change, Setting::resolutions, "without the coarsest"}, {Remedy::change, Setting::iso}}
      : other.separates ? Hint(Remedy::try_value, Setting::iso, fmt::format("{}", other.iso))
                        : Hint("try another input: no iso value separates these samples into two groups"));
}

// Sets all errors except `rounding`; `number` is the number of the contestant.
using ErrorMeasurement =
    std::function<Result<void>(const MeasuredMesh& specimen, std::size_t number, BenchErrors& errors)>;

Result<void> measure_level_errors(const field::ScalarField& field, const BenchOptions& options,
                                  const ErrorMeasurement& judge, bool in_finer, std::vector<BenchRow>& rows,
                                  const Context& context) {
  std::size_t number = 0;
  for (const Contestant& contestant : contestants(options)) {
    const extract::MethodInfo& method = contestant.method;
    extract::Extractor& extractor = *contestant.backend.extractor;
    extract::ExtractOptions extract = extract_options(field, method.method, options);
    extract.cap = true;
    const auto capped = TRY(extractor.extract(field, extract, Context(context.memory())));
    const double volume = mesh::measure_size(capped.mesh).volume;
    extract.cap = false;
    extract.smooth_normals = method.traits.gradient_normals;
    const auto open = TRY(extractor.extract(field, extract, context));
    if (open.mesh.triangles.empty()) return no_surface(field, options.iso, in_finer);
    BenchErrors judged;
    judged.rounding = accuracy::IndexMesh(open.mesh, field, extract).rounding();
    TRY(judge({field, extract, open.mesh, volume}, number, judged));
    for (BenchRow& row : rows) {
      if (contestant.is(row)) static_cast<BenchErrors&>(row) = judged;
    }
    ++number;
  }
  return {};
}

Result<void> add_level(BenchResult& result, const field::ScalarField& field, const BenchOptions& options,
                       const ErrorMeasurement& judge, bool in_finer, const Context& context) {
  auto rows = TRY(time_level(field, result.levels.size(), options, context));
  TRY(measure_level_errors(field, options, judge, in_finer, rows, context));
  result.levels.push_back({size_text(field), cells_of(field), spacing_of(field), false});
  result.rows.insert(result.rows.end(), rows.begin(), rows.end());
  return {};
}

double relative_error(double measured, double exact) { return std::abs(measured / exact - 1); }

// Returns the order of one error over the levels of one method and backend.
std::optional<ConvergenceOrder> order_of(const BenchResult& result, const BenchOrders& of, double floor,
                                         const std::function<std::optional<double>(const BenchRow&)>& error) {
  std::vector<double> spacings;
  std::vector<double> errors;
  for (const BenchRow& row : result.rows) {
    if (row.method != of.method || row.backend != of.backend) continue;
    if (result.levels[row.level].is_truth) continue;
    const double spacing = result.levels[row.level].spacing;
    if (!spacings.empty() && spacings.back() == spacing) continue;  // the same mesh with another number of threads
    const auto value = error(row);
    if (!value) continue;
    spacings.push_back(spacing);
    errors.push_back(*value);
  }
  return observed_order(spacings, errors, floor);
}

// `uncertainty`: relative uncertainty of the true area and volume.
void add_orders_and_front(BenchResult& result, const BenchOptions& options,
                          const field::SurfaceSize& uncertainty = {}) {
  double rounding = 0;
  for (const BenchRow& row : result.rows) rounding = std::max(rounding, row.rounding);
  const field::SurfaceSize floor{std::max(kRounding, uncertainty.area), std::max(kRounding, uncertainty.volume)};
  for (const Contestant& contestant : contestants(options)) {
    BenchOrders orders;
    orders.method = contestant.method.method;
    orders.backend = contestant.backend.name;
    const auto angle = [](const std::optional<accuracy::AngleStatistics>& normals) {
      return normals ? std::optional(normals->rms_degrees) : std::nullopt;
    };
    orders.position = order_of(result, orders, rounding, [](const BenchRow& row) {
      return row.position ? std::optional(row.position->rms.world) : std::nullopt;
    });
    orders.smooth_normals = order_of(result, orders, 0, [&](const BenchRow& row) { return angle(row.smooth_normals); });
    orders.flat_normals = order_of(result, orders, 0, [&](const BenchRow& row) { return angle(row.flat_normals); });
    orders.area = order_of(result, orders, floor.area, [](const BenchRow& row) { return row.area_error; });
    orders.volume = order_of(result, orders, floor.volume, [](const BenchRow& row) { return row.volume_error; });
    result.orders.push_back(std::move(orders));
  }
  std::vector<BenchRow*> measured;
  std::vector<Cost> costs;
  for (BenchRow& row : result.rows) {
    if (!row.position) continue;
    measured.push_back(&row);
    costs.push_back({row.rms_above_rounding(), row.median_seconds});
  }
  const std::vector<bool> front = pareto_front(costs);
  for (std::size_t r = 0; r < front.size(); ++r) measured[r]->on_front = front[r];
  for (std::string& missing : missing_methods(options.backends, options.methods)) {
    result.notes.push_back(std::move(missing));
  }
  for (const extract::MethodInfo& method : options.methods) {
    if (const std::string reason = extract::why_no_gradient_normals(method); !reason.empty()) {
      result.notes.push_back("not applicable: " + reason);
    }
  }
}

field::SurfaceSize relative_uncertainty(const ReferenceSize& reference) {
  return {reference.uncertainty.area / reference.size.area, reference.uncertainty.volume / reference.size.volume};
}

std::string describe_reference(const ReferenceSize& reference) {
  const field::SurfaceSize uncertainty = relative_uncertainty(reference);
  if (reference.closed_form) return "the formula; distances, area and volume in closed form";
  return fmt::format(
      "the formula; points by closest-point iteration to 1e-10, area and volume by integration along columns to {:.1g} "
      "and {:.1g}",
      uncertainty.area, uncertainty.volume);
}

// One contestant's surface of the finest data, which are the truth.
struct ReferenceSurface {
  field::SurfaceSize size;
  bool closed = false;
  glm::dvec3 low{std::numeric_limits<double>::infinity()};  // bounding box in index space
  glm::dvec3 high{-std::numeric_limits<double>::infinity()};
};

bool is_closed(const mesh::Mesh& mesh) { return mesh::measure_topology(mesh).open_edges == 0; }

Result<ReferenceSurface> extract_reference_surface(const field::ScalarField& field, const Contestant& contestant,
                                                   const BenchOptions& options, const Context& context) {
  extract::Extractor& extractor = *contestant.backend.extractor;
  extract::ExtractOptions extract = extract_options(field, contestant.method.method, options);
  const auto open = TRY(extractor.extract(field, extract, Context(context.memory())));
  if (open.mesh.triangles.empty()) return no_surface(field, options.iso, false);
  ReferenceSurface surface;
  surface.size.area = mesh::measure_size(open.mesh).area;
  surface.closed = is_closed(open.mesh);
  const accuracy::IndexMesh placed(open.mesh, field, extract);
  for (std::size_t v = 0; v < open.mesh.positions.size(); ++v) {
    surface.low = glm::min(surface.low, placed.vertex(v));
    surface.high = glm::max(surface.high, placed.vertex(v));
  }
  extract.cap = true;
  const auto capped = TRY(extractor.extract(field, extract, Context(context.memory())));
  surface.size.volume = mesh::measure_size(capped.mesh).volume;
  return surface;
}

// Returns whether the samples of `coarse`, the finest data coarsened by `factor`, contain the whole surface.
bool covers(const field::ScalarField& coarse, int factor, const ReferenceSurface& surface) {
  const auto* dense = std::get_if<field::DenseSamples>(&coarse.samples);
  if (dense == nullptr) return true;
  const glm::dvec3 low((factor - 1) / 2.0);
  const glm::dvec3 high = low + static_cast<double>(factor) * glm::dvec3(dense->dims - 1);
  return glm::all(glm::greaterThanEqual(surface.low, low)) && glm::all(glm::lessThanEqual(surface.high, high));
}

// Returns a note about the samples that coarsen() drops; empty if none.
std::string dropped_samples_note(const field::ScalarField& field, int factor) {
  const auto* dense = std::get_if<field::DenseSamples>(&field.samples);
  if (dense == nullptr) return "";
  const glm::ivec3 rest = dense->dims % factor;
  if (rest == glm::ivec3(0)) return "";
  return fmt::format(
      "coarser by {}: without the last {}, {} and {} samples along x, y and z, which do not fill a block of {}^3",
      factor, rest.x, rest.y, rest.z, factor);
}

}  // namespace

std::vector<std::string> missing_methods(std::span<const BenchBackend> backends,
                                         std::span<const extract::MethodInfo> methods) {
  std::vector<std::string> missing;
  for (const BenchBackend& backend : backends) {
    for (const extract::MethodInfo& method : methods) {
      if (!backend.applies_to(method.method) || backend.extractor->has(method.method)) continue;
      missing.push_back(
          fmt::format("the backend {} does not have {}, so the table omits it", backend.name, method.title));
    }
  }
  return missing;
}

Result<void> check_thread_counts(std::span<const int> threads) {
  const int most = tbb::this_task_arena::max_concurrency();
  for (const int count : threads) {
    if (count <= most) continue;
    return fail(
        ErrorCode::usage,
        fmt::format("expected at most {} threads, which this machine can run at the same time, found {}", most, count),
        "choose fewer threads: bench measures only as many as the machine can run");
  }
  return {};
}

Result<BenchResult> bench_demo(std::string_view name, const std::vector<int>& sizes, const BenchOptions& options,
                               const Context& context) {
  const field::AnalyticField* formula = field::find_analytic_field(name);
  if (formula == nullptr) {
    return fail(ErrorCode::usage,
                fmt::format("{}{}: the demo field has no formula to measure errors against", field::kDemoPrefix, name),
                "choose another demo field, or a file");
  }
  TRY(check_thread_counts(options.threads));
  const ReferenceSize reference = find_reference_size(*formula, options.iso, &context.progress());
  BenchResult result;
  result.input = fmt::format("{}{}", field::kDemoPrefix, name);
  result.iso = options.iso;
  result.truth = describe_reference(reference);
  for (const int size : sizes) {
    const auto field = TRY(field::make_demo_field(fmt::format("{}?size={}", result.input, size), context));
    const ErrorMeasurement judge = [&](const MeasuredMesh& specimen, std::size_t /*number*/,
                                       BenchErrors& errors) -> Result<void> {
      const auto measured = TRY(
          accuracy::measure_analytic_error(specimen.mesh, specimen.field, specimen.extracted, nullptr, {}, context));
      const std::optional<accuracy::AnalyticError>& error = measured;
      if (!error) return {};
      errors.position = error->interior;
      if (specimen.extracted.smooth_normals) errors.smooth_normals = error->smooth_normals;
      errors.flat_normals = error->flat_normals;
      errors.area_error = relative_error(error->area, reference.size.area * error->unit * error->unit);
      errors.volume_error =
          relative_error(specimen.volume, reference.size.volume * error->unit * error->unit * error->unit);
      return {};
    };
    const bool in_finer = size != sizes.back() && reference.size.area > 0;
    TRY(add_level(result, field, options, judge, in_finer, context));
  }
  add_orders_and_front(result, options, relative_uncertainty(reference));
  return result;
}

Result<BenchResult> bench_field(const field::ScalarField& field, const std::vector<int>& factors,
                                const BenchOptions& options, const Context& context) {
  TRY(check_thread_counts(options.threads));
  BenchResult result;
  result.input = field.source;
  result.iso = options.iso;
  result.truth = fmt::format(
      "the trilinear interpolant of the finest data ({}); area and volume of its meshes; the orders of "
      "convergence exclude the finest data",
      size_text(field));
  std::vector<ReferenceSurface> finest;  // by contestant number
  for (const Contestant& contestant : contestants(options)) {
    auto surface = TRY(extract_reference_surface(field, contestant, options, context));
    finest.push_back(surface);
  }
  std::vector<std::string> not_comparable;  // sizes
  for (const int factor : factors) {
    std::optional<field::ScalarField> coarse;
    if (factor > 1) {
      coarse = TRY(field::coarsen(field, factor, context));
      if (std::string dropped = dropped_samples_note(field, factor); !dropped.empty()) {
        result.notes.push_back(std::move(dropped));
      }
    }
    const ErrorMeasurement judge = [&](const MeasuredMesh& specimen, std::size_t number,
                                       BenchErrors& errors) -> Result<void> {
      const ReferenceSurface& exact = finest[number];
      extract::ExtractOptions of_finest = specimen.extracted;
      of_finest.output_from_index = field.index_to_world;
      const auto measured = TRY(accuracy::measure_field_error(specimen.mesh, field, of_finest, {}, context));
      accuracy::ErrorStatistics& position = errors.position.emplace(measured.interior);
      for (accuracy::Length* length : {&position.rms, &position.percentile99, &position.max}) length->voxels /= factor;
      if (factor > 1) {
        if (exact.closed && covers(specimen.field, factor, exact) && is_closed(specimen.mesh)) {
          errors.area_error = relative_error(mesh::measure_size(specimen.mesh).area, exact.size.area);
          errors.volume_error = relative_error(specimen.volume, exact.size.volume);
        } else if (const std::string size = size_text(specimen.field);
                   not_comparable.empty() || not_comparable.back() != size) {
          not_comparable.push_back(size);
        }
      }
      return {};
    };
    TRY(add_level(result, coarse ? *coarse : field, options, judge, factor > 1, context));
    result.levels.back().is_truth = factor == 1;
  }
  if (!not_comparable.empty()) {
    result.notes.push_back(fmt::format(
        "no errors of area and volume with {} samples along an axis: the surface is open, or the surface of "
        "the finest data extends beyond the box of the coarser data",
        fmt::join(not_comparable, ", ")));
  }
  add_orders_and_front(result, options);
  return result;
}

}  // namespace isoextract::bench

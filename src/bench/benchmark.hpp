// Measures error against run time: every method, backend and number of threads, at several resolutions of one field.
//
// Times the extraction alone: positions and triangles in memory, without normals and caps. After one warm-up each
// setting runs `repeats` times. The settings of a resolution take turns in alternating order, so other load on the
// machine hits all of them alike. The error is measured once for each method, backend and resolution.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "accuracy/analytic_error.hpp"
#include "accuracy/error_statistics.hpp"
#include "bench/convergence.hpp"
#include "extract/extractor.hpp"

namespace isoextract::bench {

struct BenchBackend {
  std::string name;  // "cpu", "gpu", or the name of a variant
  std::shared_ptr<extract::Extractor> extractor;
  std::optional<extract::Method> only{};  // set if the variant affects one method only

  [[nodiscard]] bool applies_to(extract::Method method) const { return only.value_or(method) == method; }
  [[nodiscard]] bool runs(extract::Method method) const { return applies_to(method) && extractor->has(method); }
};

// Returns one sentence (without full stop) for each pair of a backend and a method that the backend applies to but
// lacks.
[[nodiscard]] std::vector<std::string> missing_methods(std::span<const BenchBackend> backends,
                                                       std::span<const extract::MethodInfo> methods);

struct BenchOptions {
  double iso = 0;
  extract::NanPolicy nan = extract::NanPolicy::error;
  std::vector<extract::MethodInfo> methods;
  std::vector<BenchBackend> backends;
  std::vector<int> threads;  // numbers of threads, 1 or more
  int repeats = 5;           // timed runs of each setting, 1 or more
};

// One resolution.
struct BenchLevel {
  std::string size;  // samples along an axis ("64") or along each axis ("91x109x91")
  std::uint64_t cells = 0;
  double spacing = 0;     // side of a cube of a voxel's volume, in world units
  bool is_truth = false;  // the level that all others are compared with; not used for convergence orders
};

// Median times of the stages of an extraction on a device, in seconds. The processor welds.
struct BenchDeviceTimes {
  double upload = 0;
  double count = 0;
  double capture = 0;
  double read_back = 0;
  double weld = 0;
  std::uint64_t bytes_uploaded = 0;
  std::uint64_t bytes_captured = 0;

  [[nodiscard]] double draw() const { return count + capture; }  // both passes over the cells
};

// Errors of the mesh of one method and backend at one level; the number of threads does not matter. Errors of normals
// are set only if the truth is a formula; `smooth_normals` also needs a method with MethodTraits::gradient_normals.
struct BenchErrors {
  // At points inside the triangles, in voxels of this resolution and in world units.
  std::optional<accuracy::ErrorStatistics> position;
  double rounding = 0;  // float32 rounding in world units; smaller errors count as equal
  std::optional<accuracy::AngleStatistics> smooth_normals;
  std::optional<accuracy::AngleStatistics> flat_normals;
  std::optional<double> area_error;  // |measured / true - 1|; absent if it cannot be compared
  std::optional<double> volume_error;

  // Returns the rms error in world units, at least `rounding`. Requires `position`.
  [[nodiscard]] double rms_above_rounding() const { return std::max(position.value().rms.world, rounding); }
};

struct BenchRow : BenchErrors {
  std::size_t level = 0;
  extract::Method method = extract::Method::mc;
  std::string backend;
  int threads = 1;
  std::uint64_t triangles = 0;
  double median_seconds = 0;
  double min_seconds = 0;
  double max_seconds = 0;
  std::optional<BenchDeviceTimes> device;
  // On the Pareto front: no other row with `position`, of any level, is at least as good in rms_above_rounding() and
  // median time and better in one of them.
  bool on_front = false;
};

struct BenchOrders {
  extract::Method method = extract::Method::mc;
  std::string backend;
  std::optional<ConvergenceOrder> position;  // order of the rms error
  std::optional<ConvergenceOrder> smooth_normals;
  std::optional<ConvergenceOrder> flat_normals;
  std::optional<ConvergenceOrder> area;
  std::optional<ConvergenceOrder> volume;
};

struct BenchResult {
  std::string input;
  double iso = 0;
  std::string truth;               // reference of the errors, a sentence without full stop
  std::vector<std::string> notes;  // missing or inapplicable parts and the reason, each without full stop
  std::vector<BenchLevel> levels;  // coarse to fine
  std::vector<BenchRow> rows;
  std::vector<BenchOrders> orders;
};

// Fails with ErrorCode::usage if a count exceeds the threads that this process may run at a time.
[[nodiscard]] Result<void> check_thread_counts(std::span<const int> threads);

// Benchmarks a demo field with a formula, at `sizes` samples along each axis, in ascending order. `name` lacks "demo:".
// Compares areas and volumes with find_reference_size(); measures volumes on capped meshes. Fails with
// ErrorCode::usage for a demo without formula or as check_thread_counts() does, with ErrorCode::input if there is no
// surface, and as field::make_demo_field() and extraction do.
[[nodiscard]] Result<BenchResult> bench_demo(std::string_view name, const std::vector<int>& sizes,
                                             const BenchOptions& options, const Context& context);

// Benchmarks a field and versions of it that are coarser by `factors` (powers of two, falling; the last may be 1). The
// truth is the field's own trilinear interpolant; areas and volumes are compared with the mesh of the field by the same
// method and backend. Coarser data cover a smaller box: if one of the surfaces is open or the field's surface leaves
// that box, areas and volumes are not compared, and a note says so. Fails with ErrorCode::input if there is no surface,
// and as check_thread_counts(), field::coarsen() and extraction do.
[[nodiscard]] Result<BenchResult> bench_field(const field::ScalarField& field, const std::vector<int>& factors,
                                              const BenchOptions& options, const Context& context);

}  // namespace isoextract::bench

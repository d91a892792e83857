// Error against run time: every method, backend and number of threads at several resolutions of one field.
//
// Timed is the extraction alone, positions and triangles without normals and caps, in memory. After one warm-up each
// setting runs `repeats` times; the settings of a resolution take turns, in alternating order, so that what the machine
// does besides hits all of them alike. The error is measured once for each method, backend and resolution.
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
  std::string name;  // "cpu", "gpu", and others for variants of these
  std::shared_ptr<extract::Extractor> extractor;
  std::optional<extract::Method> only{};  // of a variant that concerns one method

  [[nodiscard]] bool concerns(extract::Method method) const { return only.value_or(method) == method; }
  [[nodiscard]] bool runs(extract::Method method) const { return concerns(method) && extractor->has(method); }
};

// Which of the methods that concern a backend it does not have, a sentence without its full stop each.
[[nodiscard]] std::vector<std::string> missing_methods(std::span<const BenchBackend> backends,
                                                       std::span<const extract::MethodInfo> methods);

struct BenchOptions {
  double iso = 0;
  extract::NanPolicy nan = extract::NanPolicy::error;
  std::vector<extract::MethodInfo> methods;
  std::vector<BenchBackend> backends;
  std::vector<int> threads;
  int repeats = 5;
};

// One resolution.
struct BenchLevel {
  std::string size;  // samples along an axis, or along each: "64", "91x109x91"
  std::uint64_t cells = 0;
  double spacing = 0;     // the side of a cube of a voxel's volume, in the world's units
  bool is_truth = false;  // the data that the others are measured against: in no order of convergence
};

// Where the time of a device went: medians of the stages, in seconds.
struct BenchDeviceTimes {
  double upload = 0;
  double count = 0;
  double capture = 0;
  double read_back = 0;
  double weld = 0;
  std::uint64_t bytes_uploaded = 0;
  std::uint64_t bytes_captured = 0;

  [[nodiscard]] double draw() const { return count + capture; }  // the two passes over the cells
};

// Of the mesh that one method and backend make of one level, whatever the number of threads. No smooth normals where
// the method has none.
struct BenchErrors {
  std::optional<accuracy::ErrorStatistics>
      position;         // inside the triangles; in voxels of its resolution and in world units
  double rounding = 0;  // how far float32 moves vertices, in world units; smaller errors are all alike
  std::optional<accuracy::AngleStatistics> smooth_normals;  // these where the truth is a formula
  std::optional<accuracy::AngleStatistics> flat_normals;
  std::optional<double> area_error;  // |measured / true - 1|; nothing where there is nothing to compare with
  std::optional<double> volume_error;

  // In world units; where positions were measured.
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
  bool on_front = false;  // no other measured row is at least as good in rms_above_rounding() and median time, and
                          // better in one
};

struct BenchOrders {
  extract::Method method = extract::Method::mc;
  std::string backend;
  std::optional<ConvergenceOrder> position;  // of the rms
  std::optional<ConvergenceOrder> smooth_normals;
  std::optional<ConvergenceOrder> flat_normals;
  std::optional<ConvergenceOrder> area;
  std::optional<ConvergenceOrder> volume;
};

struct BenchResult {
  std::string input;
  double iso = 0;
  std::string truth;               // what the errors are measured against, as a sentence without its full stop
  std::vector<std::string> notes;  // what was left out or is not applicable and why, likewise
  std::vector<BenchLevel> levels;  // coarse to fine
  std::vector<BenchRow> rows;
  std::vector<BenchOrders> orders;
};

// More threads than this process may run at a time would be those threads in name only: ErrorCode::usage.
[[nodiscard]] Result<void> check_thread_counts(std::span<const int> threads);

// A demo field with a formula at `sizes` samples along each axis. Areas and volumes are compared with
// find_reference_size(); volumes are those of capped meshes. Fails with ErrorCode::usage for a demo without formula
// or for too many threads, and as extraction does; with ErrorCode::input where there is no surface.
[[nodiscard]] Result<BenchResult> bench_demo(std::string_view name, const std::vector<int>& sizes,
                                             const BenchOptions& options, const Context& context);

// A field and coarser versions of it, `factors` (powers of two, falling, the last may be 1). The truth is the field's
// own trilinear interpolant; areas and volumes are compared with those of the same method on the field itself. Coarser
// data cover a smaller box. Where the surface is open, or the field's own leaves that box, there is no such comparison,
// and a note says so. Fails as bench_demo() does.
[[nodiscard]] Result<BenchResult> bench_field(const field::ScalarField& field, const std::vector<int>& factors,
                                              const BenchOptions& options, const Context& context);

}  // namespace isoextract::bench

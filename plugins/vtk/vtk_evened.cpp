// Rectilinear grids with uneven distances, as an even lattice.
#include <algorithm>
#include <cmath>
#include <limits>

#include <vtkDataArray.h>

#include "vtk_data_sets.hpp"

namespace isoextract_vtk {
namespace {

// Sample i of the even axis is between samples `lower` and lower + 1 of the uneven one.
struct Weight {
  std::size_t lower = 0;
  double upper_part = 0;
};

struct EvenAxis {
  double first = 0;
  double step = 1;
  std::vector<Weight> weights;  // of each even sample
};

// Centers of the intervals.
std::vector<double> centers_of(const std::vector<double>& points) {
  if (points.size() < 2) return points;
  std::vector<double> centers;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) centers.push_back((points[i] + points[i + 1]) / 2);
  return centers;
}

double smallest_step(const std::vector<double>& coordinates) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < coordinates.size(); ++i) {
    smallest = std::min(smallest, std::abs(coordinates[i + 1] - coordinates[i]));
  }
  return smallest;
}

std::uint64_t even_count(const std::vector<double>& coordinates, bool even, double factor) {
  if (even || coordinates.size() < 3) return coordinates.size();
  const double length = std::abs(coordinates.back() - coordinates.front());
  const double count = std::ceil(length / (smallest_step(coordinates) * factor) * (1 - 1e-9)) + 1;
  return static_cast<std::uint64_t>(std::clamp(count, 2.0, 2147483647.0));
}

EvenAxis even_axis(const std::vector<double>& coordinates, std::uint64_t count) {
  EvenAxis axis;
  axis.first = coordinates.front();
  if (count > 1) axis.step = (coordinates.back() - coordinates.front()) / static_cast<double>(count - 1);
  std::size_t lower = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const double at = (axis.first + axis.step * static_cast<double>(i)) * (axis.step < 0 ? -1 : 1);
    const auto coordinate = [&](std::size_t index) { return coordinates[index] * (axis.step < 0 ? -1 : 1); };
    while (lower + 2 < coordinates.size() && coordinate(lower + 1) <= at) ++lower;
    const double part =
        coordinates.size() < 2 ? 0 : (at - coordinate(lower)) / (coordinate(lower + 1) - coordinate(lower));
    axis.weights.push_back({lower, std::clamp(part, 0.0, 1.0)});
  }
  return axis;
}

std::string range_of_steps(const std::vector<double>& coordinates) {
  double largest = 0;
  for (std::size_t i = 0; i + 1 < coordinates.size(); ++i) {
    largest = std::max(largest, std::abs(coordinates[i + 1] - coordinates[i]));
  }
  return printed(smallest_step(coordinates)) + " to " + printed(largest);
}

class EvenedGrid final : public VolumeFile {
 public:
  EvenedGrid(DataSets& data, vtkRectilinearGrid* grid) : grid_(grid), arrays_(arrays_of(data.leaves)) {
    format = data.format;
    note = data.note;
    grids = grids_of_arrays(arrays_);
    for (std::size_t i = 0; i < grids.size(); ++i) {
      const auto axes = axes_of(arrays_[i].of_cells);
      Grid& even = grids[i];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        even.dims[axis] = axes[axis].weights.size();
        even.index_to_world[4 * axis + axis] = axes[axis].step;
        even.index_to_world[4 * axis + 3] = axes[axis].first;
      }
      // Interpolated values are not integers.
      if (even.sample_type != ISOEXTRACT_NOT_SCALAR && even.sample_type != ISOEXTRACT_F64)
        even.sample_type = ISOEXTRACT_F32;
    }
    const Dims& dims = grids[0].dims;
    add_note(note, "the reader resamples the unevenly spaced samples trilinearly onto " + std::to_string(dims[0]) +
                       " x " + std::to_string(dims[1]) + " x " + std::to_string(dims[2]) + " evenly spaced samples");
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    const ArrayFacts& facts = arrays_[selection.grid];
    const Grid& grid = grids[selection.grid];
    vtkDataArray* array = find_array(grid_, facts);
    const auto axes = axes_of(facts.of_cells);
    HostMemory memory(host);
    memory.take(static_cast<std::uint64_t>(array->GetNumberOfTuples()) * grid.components * sizeof(double));
    const std::vector<double> values = values_of(array);
    const std::array<std::size_t, 2> sizes{coordinates(0, facts.of_cells).size(),
                                           coordinates(1, facts.of_cells).size()};
    // One row of even samples with their components at a time.
    std::vector<double> row(selection.count[0] * grid.components);
    std::uint64_t to = 0;
    for (std::uint64_t k = 0; k < selection.count[2]; ++k) {
      isoextract_plugin::check_cancelled(host);
      for (std::uint64_t j = 0; j < selection.count[1]; ++j) {
        const Weight z = axes[2].weights[selection.first[2] + k];
        const Weight y = axes[1].weights[selection.first[1] + j];
        for (std::uint64_t i = 0; i < selection.count[0]; ++i) {
          const Weight x = axes[0].weights[selection.first[0] + i];
          for (std::uint64_t c = 0; c < grid.components; ++c) {
            double sum = 0;
            for (std::size_t corner = 0; corner < 8; ++corner) {
              const double weight = ((corner & 1) != 0 ? x.upper_part : 1 - x.upper_part) *
                                    ((corner & 2) != 0 ? y.upper_part : 1 - y.upper_part) *
                                    ((corner & 4) != 0 ? z.upper_part : 1 - z.upper_part);
              if (weight == 0) continue;  // also where an axis has one sample
              const std::size_t sample =
                  ((z.lower + (corner >> 2)) * sizes[1] + y.lower + (corner >> 1 & 1)) * sizes[0] + x.lower +
                  (corner & 1);
              sum += weight * values[sample * grid.components + c];
            }
            row[i * grid.components + c] = sum;
          }
        }
        for (std::uint64_t i = 0; i < selection.count[0]; ++i)
          put_tuple(grid, selection, to++, row.data() + i * grid.components);
      }
    }
    return {};
  }

 private:
  [[nodiscard]] std::vector<double> coordinates(std::size_t axis, bool of_cells) const {
    const auto points = coordinates_of(grid_, axis);
    return of_cells ? centers_of(points) : points;
  }

  // Returns axes with the smallest uneven distance as step, enlarged until the lattice has at most 4 times the samples.
  [[nodiscard]] std::array<EvenAxis, 3> axes_of(bool of_cells) const {
    std::array<std::vector<double>, 3> uneven;
    std::array<bool, 3> even{};
    double most = 4;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      uneven[axis] = coordinates(axis, of_cells);
      even[axis] = is_even(coordinates(axis, false), is_single_precision(grid_, axis));
      most *= static_cast<double>(uneven[axis].size());
    }
    std::array<std::uint64_t, 3> counts{};
    for (double factor = 1;; factor *= 1.02) {
      double samples = 1;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        counts[axis] = even_count(uneven[axis], even[axis], factor);
        samples *= static_cast<double>(counts[axis]);
      }
      if (samples <= most) break;
    }
    return {even_axis(uneven[0], counts[0]), even_axis(uneven[1], counts[1]), even_axis(uneven[2], counts[2])};
  }

  vtkSmartPointer<vtkRectilinearGrid> grid_;
  std::vector<ArrayFacts> arrays_;
};

}  // namespace

Opened evened_grid(DataSets& data, vtkRectilinearGrid* grid, const Request& request) {
  if (!request.resamples) {
    std::string text = "expected evenly spaced samples, found distances from ";
    bool first = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto coordinates = coordinates_of(grid, axis);
      if (is_even(coordinates, is_single_precision(grid, axis))) continue;
      text += (first ? "" : ", ") + range_of_steps(coordinates) + " along " + std::string(1, "xyz"[axis]);
      first = false;
    }
    throw isoextract_plugin::UnevenError(text);
  }
  return std::make_unique<EvenedGrid>(data, grid);
}

}  // namespace isoextract_vtk

// Resamples cells of any kind onto a box of samples: each cell interpolates the samples inside of it. This needs no
// search for cells, and takes time proportional to cells plus samples.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkGenericCell.h>
#include <vtkIdList.h>
#include <vtkUnstructuredGrid.h>

#include "vtk_data_sets.hpp"

namespace isoextract_vtk {
namespace {

// Checks the cells' point numbers and offsets, which VTK trusts.
void check_cells(vtkUnstructuredGrid* cells) {
  vtkCellArray* array = cells->GetCells();
  if (array == nullptr || array->GetNumberOfCells() == 0) return;
  const std::vector<double> offsets = values_of(array->GetOffsetsArray());
  const auto numbers = static_cast<double>(array->GetConnectivityArray()->GetNumberOfTuples());
  if (!std::ranges::is_sorted(offsets) || offsets.front() != 0 || offsets.back() != numbers) {
    throw ReadError("expected cells whose offsets increase from 0 to " + printed(numbers) + ", found other offsets");
  }
  std::array<double, 2> range{};
  if (numbers > 0) array->GetConnectivityArray()->GetRange(range.data());
  if (range[0] < 0 || range[1] >= static_cast<double>(cells->GetNumberOfPoints())) {
    throw ReadError("expected point numbers from 0 to " + std::to_string(cells->GetNumberOfPoints() - 1) +
                    " in the cells, found " + printed(range[0]) + " to " + printed(range[1]));
  }
}

class Resampled final : public VolumeFile {
 public:
  Resampled(DataSets& data, const Request& request, const isoextract_plugin_host& host)
      : leaves_(std::move(data.leaves)), arrays_(arrays_of(leaves_)) {
    format = data.format;
    note = data.note;
    std::array<double, 6> bounds{};
    measure(bounds, host);
    grids = grids_of_arrays(arrays_);
    const double volume = (bounds[1] - bounds[0]) * (bounds[3] - bounds[2]) * (bounds[5] - bounds[4]);
    const double chosen = std::cbrt(volume / static_cast<double>(cells_));
    Dims dims{};
    std::vector<std::uint64_t> counts;
    std::string size;
    std::string spacing;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double length = bounds[2 * axis + 1] - bounds[2 * axis];
      const bool given = request.spacing[axis] > 0;
      const double intervals =
          given ? std::floor(length / request.spacing[axis] * (1 + 1e-9)) : std::max(1.0, std::round(length / chosen));
      if (!(intervals >= 1 && intervals < 2147483647.0)) {
        throw ReadError("expected a spacing that is smaller than the size of the cells' box (" + printed(length) +
                        ") and gives fewer than 2^31 samples, found " + printed(request.spacing[axis]));
      }
      const double step = given ? request.spacing[axis] : length / intervals;
      const double first = bounds[2 * axis] + (length - step * intervals) / 2;
      dims[axis] = static_cast<std::uint64_t>(intervals) + 1;
      counts.push_back(dims[axis]);
      size += (axis == 0 ? "" : " x ") + std::to_string(dims[axis]);
      spacing += (axis == 0 ? "" : ", ") + printed(step);
      for (Grid& grid : grids) {
        grid.index_to_world[4 * axis + axis] = step;
        grid.index_to_world[4 * axis + 3] = first;
      }
    }
    if (!product(counts, std::uint64_t{1} << 40))
      throw ReadError("expected a spacing of fewer samples than 2^40, found " + size);
    for (Grid& grid : grids) {
      grid.dims = dims;
      grid.is_sampled = true;
      if (grid.sample_type != ISOEXTRACT_NOT_SCALAR && grid.sample_type != ISOEXTRACT_F64)
        grid.sample_type = ISOEXTRACT_F32;
    }
    add_note(note, "the reader resamples " + std::to_string(cells_) + " cells, which do not lie on a lattice, onto " +
                       size + " samples with the spacing " + spacing +
                       (request.spacing[0] > 0 ? "" : ", which the plug-in chose by the number of cells") +
                       "; samples outside the cells are NaN");
    if (std::ranges::any_of(arrays_, [](const ArrayFacts& array) { return array.of_cells; })) {
      add_note(note, "the value of a point is the mean of its cells' values");
    }
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    const auto start = std::chrono::steady_clock::now();
    const Grid& grid = grids[selection.grid];
    const std::uint64_t samples = selection.count[0] * selection.count[1] * selection.count[2];
    HostMemory memory(host);
    memory.take(samples / 8 + 1);
    std::vector<bool> filled(samples);
    isoextract_plugin::with_sample_type(grid.sample_type, [&]<class T>(T) {
      if constexpr (std::is_floating_point_v<T>) {
        std::fill_n(static_cast<T*>(selection.box), samples, std::numeric_limits<T>::quiet_NaN());
      }
    });
    for (const auto& leaf : leaves_) resample(leaf, selection, filled, host);
    const auto outside = static_cast<std::uint64_t>(std::ranges::count(filled, false));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    ReadFacts facts;
    facts.note = "resampling took " + printed(std::round(seconds * 1000) / 1000) + " s; " + std::to_string(outside) +
                 " of " + std::to_string(samples) + " samples are outside the cells and NaN";
    return facts;
  }

 private:
  // Measures the bounds of all cells with a volume, and counts these cells.
  void measure(std::array<double, 6>& bounds, const isoextract_plugin_host& host) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    bounds = {kFar, -kFar, kFar, -kFar, kFar, -kFar};
    std::uint64_t others = 0;
    auto cell = vtkSmartPointer<vtkGenericCell>::New();
    for (const auto& leaf : leaves_) {
      isoextract_plugin::check_cancelled(host);
      if (auto* cells = vtkUnstructuredGrid::SafeDownCast(leaf)) check_cells(cells);
      for (vtkIdType i = 0; i < leaf->GetNumberOfCells(); ++i) {
        cell->SetCellType(leaf->GetCellType(i));
        if (cell->GetCellDimension() != 3) {
          // Cells that a finer AMR level covers are empty.
          others += cell->GetCellType() == VTK_EMPTY_CELL ? 0 : 1;
          continue;
        }
        std::array<double, 6> box{};
        leaf->GetCellBounds(i, box.data());
        for (std::size_t axis = 0; axis < 3; ++axis) {
          bounds[2 * axis] = std::min(bounds[2 * axis], box[2 * axis]);
          bounds[2 * axis + 1] = std::max(bounds[2 * axis + 1], box[2 * axis + 1]);
        }
        ++cells_;
      }
    }
    if (cells_ == 0) {
      throw ReadError("expected cells with a volume, found " + std::to_string(others) +
                      " points, lines and faces, which are a mesh or particles");
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double length = bounds[2 * axis + 1] - bounds[2 * axis];
      if (!(std::isfinite(length) && length > 0))
        throw ReadError("expected cells that enclose a finite volume, found a box without one");
    }
    if (others > 0) add_note(note, "the reader leaves out " + std::to_string(others) + " cells without a volume");
  }

  // Returns values at the leaf's points; averages a cell array over the 3D cells of each point.
  std::vector<double> point_values(vtkDataSet* leaf, const ArrayFacts& facts, vtkDataArray* array,
                                   HostMemory& memory) const {
    const auto components = static_cast<std::size_t>(array->GetNumberOfComponents());
    memory.take(static_cast<std::uint64_t>(leaf->GetNumberOfPoints()) * components * sizeof(double));
    if (!facts.of_cells) return values_of(array);
    memory.take(static_cast<std::uint64_t>(leaf->GetNumberOfPoints()) * sizeof(std::uint32_t));
    std::vector<double> sums(static_cast<std::size_t>(leaf->GetNumberOfPoints()) * components, 0);
    std::vector<std::uint32_t> counts(static_cast<std::size_t>(leaf->GetNumberOfPoints()), 0);
    auto points = vtkSmartPointer<vtkIdList>::New();
    auto cell = vtkSmartPointer<vtkGenericCell>::New();
    std::vector<double> tuple(components);
    for (vtkIdType i = 0; i < leaf->GetNumberOfCells(); ++i) {
      cell->SetCellType(leaf->GetCellType(i));
      if (cell->GetCellDimension() != 3) continue;
      array->GetTuple(i, tuple.data());
      leaf->GetCellPoints(i, points);
      for (vtkIdType p = 0; p < points->GetNumberOfIds(); ++p) {
        const auto point = static_cast<std::size_t>(points->GetId(p));
        ++counts[point];
        for (std::size_t c = 0; c < components; ++c) sums[point * components + c] += tuple[c];
      }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] /= counts[i / components];
    return sums;
  }

  void resample(vtkDataSet* leaf, const isoextract_volume_selection& selection, std::vector<bool>& filled,
                const isoextract_plugin_host& host) const {
    const ArrayFacts& facts = arrays_[selection.grid];
    const Grid& grid = grids[selection.grid];
    vtkDataArray* array = find_array(leaf, facts);
    if (array == nullptr) return;
    if (static_cast<std::uint64_t>(array->GetNumberOfComponents()) != grid.components) {
      throw ReadError("expected blocks whose arrays " + facts.name +
                      " have one number of components, found different numbers");
    }
    HostMemory memory(host);
    const std::vector<double> values = point_values(leaf, facts, array, memory);
    auto cell = vtkSmartPointer<vtkGenericCell>::New();
    std::vector<double> weights(64);
    std::vector<double> tuple(grid.components);
    for (vtkIdType id = 0; id < leaf->GetNumberOfCells(); ++id) {
      if (id % 4096 == 0) isoextract_plugin::check_cancelled(host);
      std::array<double, 6> box{};
      leaf->GetCellBounds(id, box.data());
      Dims first{};
      Dims end{};
      double diagonal = 0;
      if (!samples_in(grid, selection, box, first, end, diagonal)) continue;
      leaf->GetCell(id, cell);
      if (cell->GetCellDimension() != 3) continue;
      weights.resize(std::max<std::size_t>(weights.size(), static_cast<std::size_t>(cell->GetNumberOfPoints())));
      for (std::uint64_t k = first[2]; k < end[2]; ++k) {
        for (std::uint64_t j = first[1]; j < end[1]; ++j) {
          for (std::uint64_t i = first[0]; i < end[0]; ++i) {
            const std::uint64_t to = (k * selection.count[1] + j) * selection.count[0] + i;
            if (filled[to]) continue;
            const std::array<double, 3> at{world(grid, 0, selection.first[0] + i),
                                           world(grid, 1, selection.first[1] + j),
                                           world(grid, 2, selection.first[2] + k)};
            std::array<double, 3> closest{};
            std::array<double, 3> local{};
            int part = 0;
            double distance2 = 0;
            const int inside =
                cell->EvaluatePosition(at.data(), closest.data(), part, local.data(), distance2, weights.data());
            // Rounding may put a sample on a shared face outside of both cells.
            const double tolerance = 1e-6 * diagonal;
            if (inside < 0 || (inside == 0 && !(distance2 <= tolerance * tolerance))) continue;
            filled[to] = true;
            std::ranges::fill(tuple, 0);
            for (vtkIdType p = 0; p < cell->GetNumberOfPoints(); ++p) {
              const auto point = static_cast<std::size_t>(cell->GetPointId(static_cast<int>(p)));
              for (std::size_t c = 0; c < tuple.size(); ++c) {
                tuple[c] += weights[static_cast<std::size_t>(p)] * values[point * tuple.size() + c];
              }
            }
            put_tuple(grid, selection, to, tuple.data());
          }
        }
      }
    }
  }

  static double world(const Grid& grid, std::size_t axis, std::uint64_t index) {
    return grid.index_to_world[4 * axis + 3] + grid.index_to_world[4 * axis + axis] * static_cast<double>(index);
  }

  // Sets the range of the selection's samples in a cell's box. Returns false if it has none.
  static bool samples_in(const Grid& grid, const isoextract_volume_selection& selection,
                         const std::array<double, 6>& box, Dims& first, Dims& end, double& diagonal) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double step = grid.index_to_world[4 * axis + axis];
      const double start = world(grid, axis, selection.first[axis]);
      const double low = std::ceil((box[2 * axis] - start) / step - 1e-6);
      const double high = std::floor((box[2 * axis + 1] - start) / step + 1e-6);
      const auto most = static_cast<double>(selection.count[axis]) - 1;
      if (!(low <= most && high >= 0 && low <= high)) return false;
      first[axis] = static_cast<std::uint64_t>(std::max(low, 0.0));
      end[axis] = static_cast<std::uint64_t>(std::min(high, most)) + 1;
      diagonal = std::max(diagonal, box[2 * axis + 1] - box[2 * axis]);
    }
    return true;
  }

  std::vector<vtkSmartPointer<vtkDataSet>> leaves_;
  std::vector<ArrayFacts> arrays_;
  std::uint64_t cells_ = 0;
};

}  // namespace

Opened resampled_cells(DataSets& data, const Request& request, const isoextract_plugin_host& host) {
  return std::make_unique<Resampled>(data, request, host);
}

}  // namespace isoextract_vtk

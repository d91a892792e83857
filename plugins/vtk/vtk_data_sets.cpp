#include "vtk_data_sets.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>

namespace isoextract_vtk {

namespace {

StoredType memory_type(vtkAbstractArray* array) {
  using Wide = StoredType::Wide;
  if (vtkDataArray::SafeDownCast(array) == nullptr) return {};
  switch (array->GetDataType()) {
    case VTK_CHAR: return {std::is_signed_v<char> ? ISOEXTRACT_I8 : ISOEXTRACT_U8};
    case VTK_SIGNED_CHAR: return {ISOEXTRACT_I8};
    case VTK_UNSIGNED_CHAR:
    case VTK_BIT: return {ISOEXTRACT_U8};
    case VTK_SHORT: return {ISOEXTRACT_I16};
    case VTK_UNSIGNED_SHORT: return {ISOEXTRACT_U16};
    case VTK_INT: return {ISOEXTRACT_I32};
    case VTK_UNSIGNED_INT: return {ISOEXTRACT_U32};
    case VTK_LONG:
    case VTK_LONG_LONG:
    case VTK_ID_TYPE: return {ISOEXTRACT_F64, Wide::i64};
    case VTK_UNSIGNED_LONG:
    case VTK_UNSIGNED_LONG_LONG: return {ISOEXTRACT_F64, Wide::u64};
    case VTK_FLOAT: return {ISOEXTRACT_F32};
    case VTK_DOUBLE: return {ISOEXTRACT_F64};
    default: return {};
  }
}

std::string name_of(vtkAbstractArray* array) { return array->GetName() == nullptr ? "" : array->GetName(); }

vtkDataSetAttributes* attributes_of(vtkDataSet* data, bool of_cells) {
  if (of_cells) return data->GetCellData();
  return data->GetPointData();
}

}  // namespace

std::vector<ArrayFacts> arrays_of(const std::vector<vtkSmartPointer<vtkDataSet>>& leaves) {
  std::vector<ArrayFacts> arrays;
  std::set<std::pair<bool, std::string>> seen;
  for (const bool of_cells : {false, true}) {
    for (const auto& leaf : leaves) {
      vtkDataSetAttributes* attributes = attributes_of(leaf, of_cells);
      for (int i = 0; i < attributes->GetNumberOfArrays(); ++i) {
        vtkAbstractArray* array = attributes->GetAbstractArray(i);
        const std::string name = name_of(array);
        if (is_ghost_array(name) || !seen.insert({of_cells, name}).second) continue;
        ArrayFacts facts;
        facts.name = name;
        facts.of_cells = of_cells;
        facts.type = memory_type(array);
        facts.type_name = array->GetDataTypeAsString();
        facts.components = static_cast<std::uint64_t>(std::max(1, array->GetNumberOfComponents()));
        for (vtkIdType c = 0; array->HasAComponentName() && c < array->GetNumberOfComponents(); ++c) {
          std::string component = array->GetComponentName(c) == nullptr ? "?" : array->GetComponentName(c);
          std::ranges::replace(component, ' ', '_');
          facts.component_names += (c == 0 ? "" : " ") + component;
        }
        arrays.push_back(std::move(facts));
      }
    }
  }
  if (arrays.empty()) throw ReadError("expected point or cell data, found none");
  return arrays;
}

vtkDataArray* find_array(vtkDataSet* data, const ArrayFacts& facts) {
  vtkDataSetAttributes* attributes = attributes_of(data, facts.of_cells);
  vtkDataArray* array = nullptr;
  for (int i = 0; i < attributes->GetNumberOfArrays(); ++i) {  // by position, because a name may be empty
    if (name_of(attributes->GetAbstractArray(i)) == facts.name) array = attributes->GetArray(i);
  }
  const vtkIdType count = facts.of_cells ? data->GetNumberOfCells() : data->GetNumberOfPoints();
  if (array != nullptr && array->GetNumberOfTuples() != count) {
    throw ReadError("expected " + std::to_string(count) + " values of the array " + facts.name + ", found " +
                    std::to_string(array->GetNumberOfTuples()));
  }
  return array;
}

std::vector<double> values_of(vtkDataArray* array) {
  const auto components = static_cast<std::size_t>(array->GetNumberOfComponents());
  const vtkIdType tuples = array->GetNumberOfTuples();
  std::vector<double> values(static_cast<std::size_t>(tuples) * components);
  for (vtkIdType i = 0; i < tuples; ++i) array->GetTuple(i, values.data() + static_cast<std::size_t>(i) * components);
  return values;
}

void put_tuple(const Grid& grid, const isoextract_volume_selection& selection, std::uint64_t index,
               const double* tuple) {
  double value = 0;
  if (selection.component == ISOEXTRACT_COMPONENT_LENGTH) {
    for (std::uint64_t c = 0; c < grid.components; ++c) value += tuple[c] * tuple[c];
    value = std::sqrt(value);
  } else {
    value = tuple[selection.component];
  }
  if (grid.sample_type == ISOEXTRACT_F64) {
    static_cast<double*>(selection.box)[index] = value;
  } else {
    static_cast<float*>(selection.box)[index] = static_cast<float>(value);
  }
}

bool is_even(const std::vector<double>& coordinates, bool single_precision) {
  if (coordinates.size() < 3) return true;
  const double first = coordinates.front();
  const double step = (coordinates.back() - first) / static_cast<double>(coordinates.size() - 1);
  double largest = std::max(std::abs(first), std::abs(coordinates.back()));
  const double rounding = largest * (single_precision ? 2 * 1.2e-7 : 4e-16);
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const double deviation = std::abs(coordinates[i] - (first + step * static_cast<double>(i)));
    if (!(deviation <= std::max(1e-4 * std::abs(step), rounding))) return false;
  }
  return true;
}

namespace {

vtkDataArray* coordinate_array(vtkRectilinearGrid* grid, std::size_t axis) {
  return axis == 0 ? grid->GetXCoordinates() : axis == 1 ? grid->GetYCoordinates() : grid->GetZCoordinates();
}

}  // namespace

std::vector<double> coordinates_of(vtkRectilinearGrid* grid, std::size_t axis) {
  vtkDataArray* array = coordinate_array(grid, axis);
  std::array<int, 3> dims{};
  grid->GetDimensions(dims.data());
  std::vector<double> coordinates;
  if (array != nullptr && array->GetNumberOfComponents() == 1) coordinates = values_of(array);
  if (coordinates.empty() || coordinates.size() != static_cast<std::size_t>(dims[axis])) {
    throw ReadError("expected a coordinate for each point along an axis, found " + std::to_string(coordinates.size()) +
                    " for " + std::to_string(dims[axis]));
  }
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    if (!std::isfinite(coordinates[i]) || (i > 0 && coordinates[i] == coordinates[i - 1]) ||
        (i > 1 && (coordinates[i] > coordinates[i - 1]) != (coordinates[1] > coordinates[0]))) {
      throw ReadError("expected coordinates that increase or decrease along an axis, found " + printed(coordinates[i]) +
                      " as number " + std::to_string(i));
    }
  }
  return coordinates;
}

bool is_single_precision(vtkRectilinearGrid* grid, std::size_t axis) {
  vtkDataArray* const array = coordinate_array(grid, axis);
  return array != nullptr && array->GetDataType() == VTK_FLOAT;
}

namespace {

// The lattice of image data or of an evenly spaced rectilinear grid.
std::optional<LatticeFrame> frame_of(vtkDataSet* data) {
  LatticeFrame frame;
  std::array<int, 6> extent{};
  if (auto* image = vtkImageData::SafeDownCast(data)) {
    image->GetExtent(extent.data());
    image->GetOrigin(frame.origin.data());
    image->GetSpacing(frame.spacing.data());
    std::copy_n(image->GetDirectionMatrix()->GetData(), 9, frame.direction.begin());
  } else if (auto* grid = vtkRectilinearGrid::SafeDownCast(data)) {
    std::array<int, 3> dims{};
    grid->GetDimensions(dims.data());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto coordinates = coordinates_of(grid, axis);
      if (!is_even(coordinates, is_single_precision(grid, axis))) return std::nullopt;
      extent[2 * axis + 1] = dims[axis] - 1;
      frame.origin[axis] = coordinates.front();
      if (coordinates.size() > 1) {
        frame.spacing[axis] = (coordinates.back() - coordinates.front()) / static_cast<double>(coordinates.size() - 1);
      }
    }
  } else {
    return std::nullopt;
  }
  std::ranges::copy(extent, frame.extent.begin());
  return frame;
}

// Moves a frame's extent to the indices of another frame; nothing if they are not on one lattice.
std::optional<Extent> extent_on(const LatticeFrame& lattice, const LatticeFrame& frame) {
  if (frame.direction != lattice.direction) return std::nullopt;
  Extent extent = frame.extent;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::abs(frame.spacing[axis] - lattice.spacing[axis]) > 1e-6 * std::abs(lattice.spacing[axis])) {
      return std::nullopt;
    }
    double offset = 0;  // the direction is orthonormal: its transpose turns world distances into index ones
    for (std::size_t world = 0; world < 3; ++world) {
      offset += lattice.direction[3 * world + axis] * (frame.origin[world] - lattice.origin[world]);
    }
    offset /= lattice.spacing[axis];
    const double whole = std::round(offset);
    if (!(std::abs(offset - whole) <= 1e-3) || std::abs(whole) > 1e9) return std::nullopt;
    extent[2 * axis] += static_cast<std::int64_t>(whole);
    extent[2 * axis + 1] += static_cast<std::int64_t>(whole);
  }
  return extent;
}

class MemoryLattice final : public Lattice {
 public:
  MemoryLattice(DataSets& data, LatticeFrame frame, std::vector<Extent> pieces) : leaves_(std::move(data.leaves)) {
    format = data.format;
    note = data.note;
    pieces_ = std::move(pieces);
    frame.extent = pieces_[0];
    for (const Extent& piece : pieces_) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        frame.extent[2 * axis] = std::min(frame.extent[2 * axis], piece[2 * axis]);
        frame.extent[2 * axis + 1] = std::max(frame.extent[2 * axis + 1], piece[2 * axis + 1]);
      }
    }
    const auto has_ghosts = [](const vtkSmartPointer<vtkDataSet>& leaf) {
      return leaf->HasAnyGhostCells() || leaf->HasAnyGhostPoints() || leaf->HasAnyBlankCells() ||
             leaf->HasAnyBlankPoints();
    };
    if (std::ranges::any_of(leaves_, has_ghosts)) add_note(note, kGhostNote);
    set_grids(frame, arrays_of(leaves_));
  }

 protected:
  Source source(std::size_t piece, const ArrayFacts& facts, const isoextract_plugin_host& /*host*/) override {
    vtkSmartPointer<vtkDataArray> array = find_array(leaves_[piece], facts);
    if (array == nullptr) throw ReadError("expected the array " + facts.name + " in each block, found one without it");
    if (array->GetDataType() == VTK_BIT) {  // packed
      auto bytes = vtkSmartPointer<vtkUnsignedCharArray>::New();
      bytes->DeepCopy(array);
      array = bytes;
    }
    const StoredType type = memory_type(array);
    return {type, false, static_cast<std::uint64_t>(array->GetNumberOfComponents()),
            [array, type](std::uint64_t first, std::uint64_t count, void* to) {
              const auto* from = static_cast<const char*>(array->GetVoidPointer(0));
              std::copy_n(from + first * type.bytes(), count * type.bytes(), static_cast<char*>(to));
            }};
  }

 private:
  std::vector<vtkSmartPointer<vtkDataSet>> leaves_;
};

}  // namespace

Opened lattice_of(DataSets& data) {
  const auto frame = frame_of(data.leaves[0]);
  if (!frame) return nullptr;
  std::vector<Extent> pieces;
  for (const auto& leaf : data.leaves) {
    const auto piece = frame_of(leaf);
    const auto extent = piece ? extent_on(*frame, *piece) : std::nullopt;
    if (!extent) return nullptr;
    pieces.push_back(*extent);
  }
  return std::make_unique<MemoryLattice>(data, *frame, std::move(pieces));
}

}  // namespace isoextract_vtk

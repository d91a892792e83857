#include "vtk_lattice.hpp"

#include <algorithm>
#include <set>

namespace isoextract_vtk {

bool is_ghost_array(const std::string& name) { return name == "vtkGhostType" || name == "vtkGhostLevels"; }

void add_note(std::string& note, const std::string& text) { note += (note.empty() || text.empty() ? "" : "; ") + text; }

std::vector<Grid> grids_of_arrays(const std::vector<ArrayFacts>& arrays) {
  std::set<std::string> of_points;
  for (const ArrayFacts& array : arrays) {
    if (!array.of_cells) of_points.insert(array.name);
  }
  std::vector<Grid> grids;
  for (const ArrayFacts& array : arrays) {
    Grid grid;
    grid.name = (array.of_cells && of_points.contains(array.name) ? "cell:" : "") + array.name;
    grid.type_name = array.type_name + (array.of_cells ? " of cells" : " of points");
    grid.sample_type = array.type.sample_type;
    grid.components = array.components;
    grid.component_names = array.component_names;
    grids.push_back(std::move(grid));
  }
  return grids;
}

StoredBox Lattice::box_of(const Extent& piece, bool of_cells) const {
  StoredBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t start = frame_.extent[2 * axis];
    const bool flat = frame_.extent[2 * axis + 1] == start;  // one layer of cells
    box.first[axis] = static_cast<std::uint64_t>(piece[2 * axis] - start);
    const std::int64_t intervals = piece[2 * axis + 1] - piece[2 * axis];
    box.dims[axis] = static_cast<std::uint64_t>(of_cells && !flat ? intervals : intervals + 1);
  }
  return box;
}

void Lattice::set_grids(const LatticeFrame& frame, std::vector<ArrayFacts> arrays) {
  constexpr std::int64_t kMost = 2147483647;
  frame_ = frame;
  arrays_ = std::move(arrays);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t first = frame.extent[2 * axis];
    const std::int64_t last = frame.extent[2 * axis + 1];
    if (first < -kMost || last > kMost || last < first || last - first >= kMost) {
      throw ReadError("expected an extent with points, found " + std::to_string(first) + " to " + std::to_string(last));
    }
  }
  for (const Extent& piece : pieces_) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (piece[2 * axis] < frame.extent[2 * axis] || piece[2 * axis + 1] > frame.extent[2 * axis + 1] ||
          piece[2 * axis] > piece[2 * axis + 1]) {
        throw ReadError("expected pieces inside the whole extent, found one from " + std::to_string(piece[2 * axis]) +
                        " to " + std::to_string(piece[2 * axis + 1]));
      }
    }
  }
  grids = grids_of_arrays(arrays_);
  for (std::size_t i = 0; i < grids.size(); ++i) {
    grids[i].dims = box_of(frame.extent, arrays_[i].of_cells).dims;
    for (std::size_t world = 0; world < 3; ++world) {
      double* const row = grids[i].index_to_world.data() + 4 * world;
      row[3] = frame.origin[world];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        row[axis] = frame.direction[3 * world + axis] * frame.spacing[axis];
        const bool flat = frame.extent[2 * axis] == frame.extent[2 * axis + 1];
        row[3] += row[axis] * (static_cast<double>(frame.extent[2 * axis]) + (arrays_[i].of_cells && !flat ? 0.5 : 0));
      }
    }
    if (arrays_[i].type.wide != StoredType::Wide::none && note.find(kWideNote) == std::string::npos) {
      add_note(note, std::string(kWideNote));
    }
  }
}

namespace {

// Fails if the boxes together lack samples of the selection. Cuts the selection at all box boundaries, and checks the
// first sample of each block.
void check_covered(const std::vector<StoredBox>& boxes, const isoextract_volume_selection& selection) {
  std::array<std::vector<std::uint64_t>, 3> cuts;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::uint64_t first = selection.first[axis];
    const std::uint64_t end = first + selection.count[axis];
    std::set<std::uint64_t> sorted{first};
    for (const StoredBox& box : boxes) {
      for (const std::uint64_t cut : {box.first[axis], box.first[axis] + box.dims[axis]}) {
        if (cut > first && cut < end) sorted.insert(cut);
      }
    }
    cuts[axis].assign(sorted.begin(), sorted.end());
  }
  for (const std::uint64_t z : cuts[2]) {
    for (const std::uint64_t y : cuts[1]) {
      for (const std::uint64_t x : cuts[0]) {
        const Dims sample{x, y, z};
        const auto holds = [&](const StoredBox& box) {
          bool inside = true;
          for (std::size_t axis = 0; axis < 3; ++axis) {
            inside = inside && sample[axis] >= box.first[axis] && sample[axis] - box.first[axis] < box.dims[axis];
          }
          return inside;
        };
        if (std::ranges::none_of(boxes, holds)) {
          throw ReadError("expected pieces that cover the whole extent, found none with sample (" + std::to_string(x) +
                          ", " + std::to_string(y) + ", " + std::to_string(z) + ")");
        }
      }
    }
  }
}

}  // namespace

ReadFacts Lattice::read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) {
  const Grid& grid = grids[selection.grid];
  const ArrayFacts& array = arrays_[selection.grid];
  std::vector<StoredBox> boxes;
  for (const Extent& piece : pieces_) boxes.push_back(box_of(piece, array.of_cells));
  check_covered(boxes, selection);
  ReadFacts facts;
  facts.parts = pieces_.size() > 1 ? pieces_.size() : 0;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    StoredBox& box = boxes[i];
    bool needed = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      needed = needed && box.first[axis] < selection.first[axis] + selection.count[axis] &&
               selection.first[axis] < box.first[axis] + box.dims[axis];
    }
    if (!needed) continue;
    if (facts.parts > 0) ++facts.parts_read;
    const Source from = source(i, array, host);
    if (from.type.sample_type != array.type.sample_type || from.type.wide != array.type.wide ||
        from.components != array.components) {
      throw ReadError("expected pieces whose arrays " + array.name + " have one type, found different types");
    }
    box.type = from.type;
    box.swap = from.swap;
    fill_from_stored(grid, box, from.read, selection, host);
  }
  return facts;
}

}  // namespace isoextract_vtk

// Arrays on a lattice that is cut into one or more pieces, as in .vti and .pvti files and in VTK's image data.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "vtk_volume.hpp"

namespace isoextract_vtk {

using Extent = std::array<std::int64_t, 6>;  // the first and last point along x, y and z

struct ArrayFacts {
  std::string name;
  bool of_cells = false;  // else of points
  StoredType type;        // not scalar: listed, but cannot be read
  std::string type_name;  // for users
  std::uint64_t components = 1;
  std::string component_names;
};

// Point (i, j, k) of the extent is at origin + direction * (spacing * (i, j, k)); the direction's rows are world axes.
struct LatticeFrame {
  std::array<double, 3> origin{};
  std::array<double, 3> spacing{1, 1, 1};
  std::array<double, 9> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};
  Extent extent{};
};

// Returns grids with the arrays' names, types and components. If arrays of points and of cells have the same name, the
// grid of the cells is "cell:NAME".
std::vector<Grid> grids_of_arrays(const std::vector<ArrayFacts>& arrays);

// Returns whether an array marks ghosts: hidden samples, and samples that pieces share. Such arrays are not listed.
bool is_ghost_array(const std::string& name);
constexpr const char* kGhostNote = "the reader ignores marks of hidden samples (vtkGhostType)";

// Appends `text` to `note`, after "; " if both have text.
void add_note(std::string& note, const std::string& text);

class Lattice : public VolumeFile {
 public:
  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override;

 protected:
  // How an array of a piece is stored.
  struct Source {
    StoredType type;
    bool swap = false;
    std::uint64_t components = 1;
    ReadNumbers read;
  };

  // Makes the grids, one for each array. Needs pieces_; throws if one is outside the frame's extent. A sample of cells
  // is at the center of its cell.
  void set_grids(const LatticeFrame& frame, std::vector<ArrayFacts> arrays);
  virtual Source source(std::size_t piece, const ArrayFacts& array, const isoextract_plugin_host& host) = 0;

  std::vector<Extent> pieces_;

 private:
  [[nodiscard]] StoredBox box_of(const Extent& piece, bool of_cells) const;

  LatticeFrame frame_;
  std::vector<ArrayFacts> arrays_;
};

}  // namespace isoextract_vtk

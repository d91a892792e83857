// Layouts with one image: VTKHDF and ITK.
#include <algorithm>
#include <cmath>

#include "hdf5_parts.hpp"

namespace isoextract_hdf5 {
namespace {

struct ImageFrame {
  std::array<double, 3> origin{};
  std::array<double, 3> spacing{1, 1, 1};
  std::array<double, 9> axes{1, 0, 0, 0, 1, 0, 0, 0, 1};  // column a is the direction of grid axis a

  // Places the sample (0, 0, 0) at `first`, in steps along the axes from the origin.
  void place(const std::array<double, 3>& first, Grid& grid) const {
    for (std::size_t row = 0; row < 3; ++row) {
      double offset = origin[row];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        grid.index_to_world[4 * row + axis] = axes[3 * row + axis] * spacing[axis];
        offset += grid.index_to_world[4 * row + axis] * first[axis];
      }
      grid.index_to_world[4 * row + 3] = offset;
    }
  }
};

template <std::size_t N>
void take_numbers(const std::vector<double>& found, std::array<double, N>& to) {
  if (found.size() == N) std::ranges::copy(found, to.begin());
}

// Returns false unless the dimensions are time (if has_time), z, y, x, and perhaps components.
bool assign_image(Grid& grid, Source& source, bool has_time) {
  const std::size_t first = has_time ? 1 : 0;
  const std::size_t rank = source.shape.size();
  if (rank != first + 3 && rank != first + 4) return false;
  if (has_time) source.volumes = {0};
  source.axis = {first + 2, first + 1, first};
  for (std::size_t axis = 0; axis < 3; ++axis) grid.dims[axis] = source.shape[source.axis[axis]];
  if (rank == first + 4) {
    source.component = first + 3;
    grid.components = source.shape[first + 3];
  }
  return true;
}

struct VtkImage {
  std::array<double, 6> extent{0, -1, 0, -1, 0, -1};
  ImageFrame frame;
  std::uint64_t steps = 0;  // 0 if it is not temporal
  std::vector<double> times;
};

void add_vtk_arrays(hid_t file, const VtkImage& image, bool is_cells, Contents& contents) {
  const std::string kind = is_cells ? "CellData" : "PointData";
  const auto group = find_object(file, "/VTKHDF/" + kind);
  if (!group) return;
  for (const std::string& name : names_in(*group)) {
    const std::string path = "/VTKHDF/" + kind + "/" + name;
    if (object_type(file, path) != H5O_TYPE_DATASET) continue;
    const Handle dataset(H5Dopen2(file, path.c_str(), H5P_DEFAULT), "HDF5 cannot open its array " + name);
    Grid grid;
    grid.name = name;
    Source source;
    source.paths = {path};
    source.shape = describe_dataset(dataset, grid);
    bool fits = assign_image(grid, source, image.steps > 0);
    std::array<double, 3> first{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double points = image.extent[2 * axis + 1] - image.extent[2 * axis] + 1;
      fits = fits && static_cast<double>(grid.dims[axis]) == (is_cells ? points - 1 : points);
      first[axis] = image.extent[2 * axis] + (is_cells ? 0.5 : 0);
    }
    if (!fits) {
      grid.type_name += " of another size than its extent";
      grid.sample_type = ISOEXTRACT_NOT_SCALAR;
    }
    image.frame.place(first, grid);
    if (is_cells) source.note = "the values belong to cells, and the samples are the centers of the cells";
    if (image.steps > 0) {
      grid.volumes = image.steps;
      grid.volume_times = image.times;
      const auto offsets = dataset_numbers(file, "/VTKHDF/Steps/" + kind + "Offsets/" + name);
      for (std::size_t step = 0; fits && step < image.steps; ++step) {
        const double index = offsets.size() == image.steps ? offsets[step] : static_cast<double>(step);
        if (!(index >= 0 && index < static_cast<double>(source.shape[0])))
          throw ReadError("expected an array " + name + " of " + std::to_string(image.steps) + " steps, found " +
                          std::to_string(source.shape[0]));
        source.volume_index.push_back(static_cast<hsize_t>(index));
      }
    }
    contents.add(std::move(grid), std::move(source));
  }
}

}  // namespace

std::optional<Contents> list_vtkhdf(hid_t file) {
  const auto root = find_object(file, "/VTKHDF");
  if (!root) return std::nullopt;
  const std::string type = attribute_text(*root, "Type");
  if (type != "ImageData") throw ReadError("expected VTKHDF of type ImageData, found type '" + type + "'");
  VtkImage image;
  const auto extent = attribute_numbers(*root, "WholeExtent");
  if (extent.size() != 6) throw ReadError("expected VTKHDF image data with six numbers of WholeExtent");
  take_numbers(extent, image.extent);
  take_numbers(attribute_numbers(*root, "Origin"), image.frame.origin);
  take_numbers(attribute_numbers(*root, "Spacing"), image.frame.spacing);
  take_numbers(attribute_numbers(*root, "Direction"), image.frame.axes);
  if (const auto steps = find_object(file, "/VTKHDF/Steps")) {
    const auto count = attribute_numbers(*steps, "NSteps");
    if (count.size() != 1 || !(count[0] >= 1 && count[0] < 1e6))
      throw ReadError("expected a number of time steps in VTKHDF's NSteps");
    image.steps = static_cast<std::uint64_t>(count[0]);
    image.times = dataset_numbers(file, "/VTKHDF/Steps/Values");
  }
  Contents contents;
  contents.format = "VTKHDF image data";
  add_vtk_arrays(file, image, false, contents);
  add_vtk_arrays(file, image, true, contents);
  return contents;
}

std::optional<Contents> list_itk(hid_t file) {
  const std::string base = "/ITKImage/0/";
  if (object_type(file, base + "VoxelData") != H5O_TYPE_DATASET) return std::nullopt;
  const Handle dataset(H5Dopen2(file, (base + "VoxelData").c_str(), H5P_DEFAULT), "HDF5 cannot open its samples");
  Contents contents;
  contents.format = "ITK HDF5 image";
  Grid grid;
  Source source;
  source.paths = {base + "VoxelData"};
  source.shape = describe_dataset(dataset, grid);
  const auto dimension = dataset_numbers(file, base + "Dimension");
  if (dimension.size() != 3 || !assign_image(grid, source, false))
    throw ReadError("expected an ITK image of three dimensions, found " + std::to_string(dimension.size()));
  ImageFrame frame;
  take_numbers(dataset_numbers(file, base + "Spacing"), frame.spacing);
  take_numbers(dataset_numbers(file, base + "Origin"), frame.origin);
  // Row a of Directions is the direction of grid axis a.
  const auto directions = dataset_numbers(file, base + "Directions");
  for (std::size_t i = 0; directions.size() == 9 && i < 9; ++i) frame.axes[3 * (i % 3) + i / 3] = directions[i];
  frame.place({}, grid);
  grid.world_space = "left-posterior-superior";
  grid.length_unit = "mm";
  contents.add(std::move(grid), std::move(source));
  return contents;
}

}  // namespace isoextract_hdf5

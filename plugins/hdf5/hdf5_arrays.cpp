// Datasets of any HDF5 file. Some programs write attributes that place them.
#include <algorithm>
#include <set>
#include <sstream>

#include "hdf5_parts.hpp"

namespace isoextract_hdf5 {
namespace {

constexpr std::size_t kMostObjects = 100000;
constexpr int kMostDepth = 64;

// One letter for each dimension: z, y, x, t (volumes), c (components).
using Letters = std::string;

bool is_usable(const Letters& letters, std::size_t rank) {
  return letters.size() == rank &&
         std::ranges::all_of(letters,
                             [&](char letter) {
                               return Letters("xyztc").find(letter) != Letters::npos &&
                                      std::ranges::count(letters, letter) == 1;
                             }) &&
         letters.find('x') != Letters::npos && letters.find('y') != Letters::npos && letters.find('z') != Letters::npos;
}

// Vigra's attribute `axistags`, which ilastik writes: JSON with a "key" for each axis.
Letters letters_of_axistags(const std::string& json) {
  Letters letters;
  for (std::size_t at = json.find("\"key\""); at != std::string::npos; at = json.find("\"key\"", at + 1)) {
    const std::size_t open = json.find('"', at + 5);
    const std::size_t close = open == std::string::npos ? open : json.find('"', open + 1);
    if (close == std::string::npos || close - open != 2) return {};
    letters += json[open + 1];
  }
  return letters;
}

// The first letter of each label of HDF5's dimension scales.
Letters letters_of_labels(const std::vector<std::string>& labels) {
  Letters letters;
  for (const std::string& label : labels) {
    if (label.size() != 1) return {};
    letters += label[0] >= 'A' && label[0] <= 'Z' ? static_cast<char>(label[0] - 'A' + 'a') : label[0];
  }
  return letters;
}

// Guesses axes from a shape. Four axes are [z, y, x, c] if the last has at most 4 samples, else [t, z, y, x].
Letters guess_letters(const std::vector<hsize_t>& shape) {
  if (shape.size() == 3) return "zyx";
  if (shape.size() == 4) return shape.back() <= 4 ? "zyxc" : "tzyx";
  return shape.back() <= 16 ? "tzyxc" : "";
}

// Sets the source's dimensions and the grid's sizes. Grid axis 0 is the last spatial dimension. Returns the world axis
// of each grid axis.
std::array<std::size_t, 3> assign_dimensions(const Letters& letters, const std::vector<hsize_t>& shape, Grid& grid,
                                             Source& source) {
  std::array<std::size_t, 3> world{};
  std::size_t next = 3;
  for (std::size_t i = 0; i < letters.size(); ++i) {
    if (letters[i] == 'c') {
      source.component = i;
      grid.components = shape[i];
    } else if (letters[i] == 't') {
      source.volumes.push_back(i);
      grid.volumes = shape[i];
    } else {
      --next;
      source.axis[next] = i;
      world[next] = static_cast<std::size_t>(letters[i] - 'x');
      grid.dims[next] = shape[i];
    }
  }
  return world;
}

// Returns three numbers of an attribute in the order of the grid's axes: the reverse of the order in the file.
std::optional<std::array<double, 3>> three_numbers(hid_t dataset, const char* name) {
  const auto found = attribute_numbers(dataset, name);
  if (found.size() != 3) return std::nullopt;
  return std::array{found[2], found[1], found[0]};
}

void place(hid_t dataset, const std::array<std::size_t, 3>& world, Grid& grid, Source& source) {
  struct Convention {
    const char* spacing;
    const char* origin;
    const char* unit;
  };
  // Conventions of ilastik and Fiji's HDF5 plug-in, of CREMI, and of various programs.
  constexpr std::array<Convention, 3> kConventions{
      Convention{"element_size_um", nullptr, "um"}, {"resolution", "offset", ""}, {"spacing", "origin", ""}};
  std::array<double, 3> spacing{1, 1, 1};
  std::array<double, 3> origin{};
  grid.has_placement = false;
  for (const Convention& convention : kConventions) {
    const auto found = three_numbers(dataset, convention.spacing);
    if (!found || std::ranges::any_of(*found, [](double size) { return !(size > 0); })) continue;
    spacing = *found;
    grid.has_placement = true;
    grid.length_unit = convention.unit;
    source.note = std::string("the attribute ") + convention.spacing + " gives the spacing";
    if (convention.origin != nullptr) {
      if (const auto offset = three_numbers(dataset, convention.origin)) {
        origin = *offset;
        source.note += std::string(" and ") + convention.origin + " the origin";
      }
      source.note += ", in the order of the dataset's axes";
    }
    break;
  }
  grid.index_to_world.fill(0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    grid.index_to_world[4 * world[axis] + axis] = spacing[axis];
    grid.index_to_world[4 * world[axis] + 3] = origin[axis];
  }
}

class Lister {
 public:
  Lister(hid_t file, const isoextract_plugin_host& host) : file_(file), host_(host) {}

  Contents list() {
    contents_.format = "HDF5";
    visit_group("/", 0);
    if (is_cut_) contents_.note = "the list ends after the first " + std::to_string(kMostObjects) + " objects";
    return std::move(contents_);
  }

 private:
  void visit_group(const std::string& path, int depth) {
    isoextract_plugin::check_cancelled(host_);
    const Handle group(H5Gopen2(file_, path.c_str(), H5P_DEFAULT), "HDF5 cannot open its group " + path);
    // Lists datasets before inner groups: a dataset that both have is listed by its name in the outer group.
    std::vector<std::string> inner_groups;
    for (const std::string& name : names_in(group)) {
      H5O_info_t info{};
      // A damaged object does not hide the others.
      if (H5Oget_info_by_name2(group, name.c_str(), &info, H5O_INFO_BASIC, H5P_DEFAULT) < 0) {
        H5Eclear2(H5E_DEFAULT);
        contents_.note = "the object " + path + name + " is damaged, so the list leaves it out";
        continue;
      }
      if (!visited_.emplace(info.fileno, info.addr).second) continue;
      if (visited_.size() > kMostObjects) {
        is_cut_ = true;
        return;
      }
      if (info.type == H5O_TYPE_GROUP && depth < kMostDepth) inner_groups.push_back(path + name + "/");
      if (info.type == H5O_TYPE_DATASET) add_dataset(path + name);
    }
    for (const std::string& inner : inner_groups) visit_group(inner, depth + 1);
  }

  void add_dataset(const std::string& path) {
    const Handle dataset(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), "HDF5 cannot open its dataset " + path);
    Grid grid;
    grid.name = path;
    Source source;
    source.paths = {path};
    source.shape = describe_dataset(dataset, grid);
    const std::size_t rank = source.shape.size();
    if (rank < 3) return;
    if (std::ranges::find(source.shape, 0U) != source.shape.end()) {
      grid.type_name += " without samples";
      grid.sample_type = ISOEXTRACT_NOT_SCALAR;
    } else if (rank > 5) {
      grid.type_name += " of " + std::to_string(rank) + " dimensions";
      grid.sample_type = ISOEXTRACT_NOT_SCALAR;
    }
    if (grid.sample_type != ISOEXTRACT_NOT_SCALAR) describe_axes(dataset, grid, source);
    contents_.add(std::move(grid), std::move(source));
  }

  static void describe_axes(hid_t dataset, Grid& grid, Source& source) {
    const std::size_t rank = source.shape.size();
    Letters letters = letters_of_axistags(attribute_text(dataset, "axistags"));
    if (!is_usable(letters, rank)) letters = letters_of_labels(attribute_texts(dataset, "DIMENSION_LABELS"));
    const bool is_stated = is_usable(letters, rank);
    if (!is_stated) letters = guess_letters(source.shape);
    if (letters.empty()) {
      grid.type_name += " of 5 dimensions without names";
      grid.sample_type = ISOEXTRACT_NOT_SCALAR;
      return;
    }
    const auto world = assign_dimensions(letters, source.shape, grid, source);
    place(dataset, world, grid, source);
    if (is_stated || rank == 3) return;
    std::string axes;
    for (const char letter : letters) axes += (axes.empty() ? "[" : ", ") + std::string(1, letter);
    source.note +=
        std::string(source.note.empty() ? "" : "; ") + "its axes have no names; the reader takes them as " + axes + "]";
  }

  hid_t file_;
  const isoextract_plugin_host& host_;
  Contents contents_;
  std::set<std::pair<unsigned long, haddr_t>> visited_;
  bool is_cut_ = false;
};

}  // namespace

Contents list_arrays(hid_t file, const isoextract_plugin_host& host) { return Lister(file, host).list(); }

}  // namespace isoextract_hdf5

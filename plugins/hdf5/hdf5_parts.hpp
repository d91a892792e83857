// Shared by the files of the HDF5 plug-in.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <hdf5.h>

#include <volume_reader.hpp>

namespace isoextract_hdf5 {

using isoextract_plugin::Grid;
using isoextract_plugin::HostMemory;
using isoextract_plugin::ReadError;
using isoextract_plugin::ReadFacts;
using isoextract_plugin::Request;

// Owns an identifier of any kind.
class Handle {
 public:
  // Throws ReadError, with `what` and the library's reason, if the identifier is negative.
  Handle(hid_t id, const std::string& what);
  Handle() : id_(H5I_INVALID_HID) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) H5Idec_ref(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor): as in the library's own calls

 private:
  hid_t id_;
};

// Throws ReadError, with `what` and the library's reason, if the status is negative.
void check(herr_t status, const std::string& what);

// Opens an object by its path; nullopt if there is none.
std::optional<Handle> find_object(hid_t file, const std::string& path);
// Returns the type of the object with that path; H5O_TYPE_UNKNOWN if it is missing or damaged.
H5O_type_t object_type(hid_t file, const std::string& path);
// Returns the sorted names of the hard links in a group, without soft and external links.
std::vector<std::string> names_in(hid_t group);

// Returns an attribute's numbers; empty if it is missing, has no numbers, or more than 65,536 of them.
std::vector<double> attribute_numbers(hid_t object, const char* name);
// Returns an attribute's texts; empty if it is missing, has no texts, or too many (65,536; 1 MiB of fixed length).
std::vector<std::string> attribute_texts(hid_t object, const char* name);
// Returns the attribute's texts joined, as Imaris stores an array of letters; "" where attribute_texts() is empty.
std::string attribute_text(hid_t object, const char* name);
// Returns the numbers of a dataset; empty if it is missing, has no numbers, or more than 65,536 of them.
std::vector<double> dataset_numbers(hid_t file, const std::string& path);

// The datasets of a grid, and the meaning of their dimensions.
struct Source {
  std::vector<std::string> paths;        // of one dataset, or of one for each volume
  std::vector<hsize_t> shape;            // of each dataset
  std::array<std::size_t, 3> axis{};     // the dimension of each grid axis
  std::vector<std::size_t> volumes;      // dimensions of the volumes, the slowest first
  std::vector<hsize_t> volume_index;     // of each volume along volumes[0], the only one; empty: in order
  std::optional<std::size_t> component;  // the dimension of the components
  std::string note;
};

// Sets the grid's type from the dataset's, and returns the dataset's shape; empty if it has no dimensions.
std::vector<hsize_t> describe_dataset(hid_t dataset, Grid& grid);
// Returns the files besides `path` that hold samples of a virtual dataset, existing or not; without names with a %,
// which stand for several files. Empty for other datasets.
std::vector<std::string> other_files(hid_t dataset, const std::string& path);
// Fills selection.box.
ReadFacts read_source(hid_t file, const std::string& path, const Source& source, const Grid& grid,
                      const isoextract_volume_selection& selection, const isoextract_plugin_host& host);

// Grids that a file holds.
struct Contents {
  std::string format;
  std::string creator;
  std::string note;
  std::vector<Grid> grids;
  std::vector<Source> sources;
  std::vector<std::string> files;  // besides the file itself
  std::uint64_t levels = 1;

  void add(Grid grid, Source source) {
    grids.push_back(std::move(grid));
    sources.push_back(std::move(source));
  }
};

// list_vtkhdf(), list_itk(), list_imaris() and list_bigdataviewer() return nullopt if the file has another layout, and
// throw ReadError if the file has their layout but is invalid.
//
// ImageData of VTKHDF 1.0 and 2.x,
// https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html#vtkhdf-file-format
std::optional<Contents> list_vtkhdf(hid_t file);
// Lists the image of ITK's HDF5ImageIO.
std::optional<Contents> list_itk(hid_t file);
// Imaris 5.5, https://imaris.oxinst.com/support/imaris-file-format
std::optional<Contents> list_imaris(hid_t file, const Request& request);
// BigDataViewer, https://imagej.net/plugins/bdv, with the voxel size of the XML file beside it.
std::optional<Contents> list_bigdataviewer(hid_t file, const Request& request);
// Lists the datasets of three or more dimensions among the first 100,000 objects, by path. Datasets of more than five
// dimensions are listed, but cannot be read.
Contents list_arrays(hid_t file, const isoextract_plugin_host& host);

}  // namespace isoextract_hdf5

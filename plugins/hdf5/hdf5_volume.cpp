// HDF5 files through the HDF5 library: known layouts, else all datasets.
#include <algorithm>
#include <filesystem>
#include <mutex>

#include "hdf5_parts.hpp"

namespace isoextract_hdf5 {
namespace {

// Serializes all calls, because the library may have been built without thread safety.
std::recursive_mutex& library_mutex() {
  static std::recursive_mutex mutex;
  return mutex;
}

// Stops the library from printing errors, which this plug-in reports, and from loading filters, which are foreign code.
void prepare_library() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  H5PLset_loading_state(0);
}

Contents list_contents(hid_t file, const Request& request, const isoextract_plugin_host& host) {
  if (auto found = list_imaris(file, request)) return std::move(*found);
  if (auto found = list_bigdataviewer(file, request)) return std::move(*found);
  if (request.level > 0)
    throw ReadError("expected level 0, the only one of this file, found " + std::to_string(request.level));
  if (auto found = list_vtkhdf(file)) return std::move(*found);
  if (auto found = list_itk(file)) return std::move(*found);
  return list_arrays(file, host);
}

class Hdf5File final : public isoextract_plugin::VolumeFile {
 public:
  Hdf5File(const Request& request, const isoextract_plugin_host& host)
      : path_(request.path), file_(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), "HDF5 cannot open it") {
    Contents contents = list_contents(file_, request, host);
    if (contents.grids.empty()) throw ReadError("expected a dataset of three dimensions or more, found none");
    format = contents.format;
    creator = contents.creator;
    note = contents.note;
    files = std::move(contents.files);
    grids = std::move(contents.grids);
    sources_ = std::move(contents.sources);
    if (contents.levels > 1) {
      note = "the file has " + std::to_string(contents.levels) + " levels, counted from 0; the reader takes level " +
             std::to_string(request.level);
    }
    list_other_files();
  }
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;
  ~Hdf5File() override {
    const std::scoped_lock lock(library_mutex());
    file_ = Handle();
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    const std::scoped_lock lock(library_mutex());
    return read_source(file_, path_, sources_[selection.grid], grids[selection.grid], selection, host);
  }

 private:
  void list_other_files() {
    for (const Source& source : sources_) {
      for (const std::string& path : source.paths) {
        if (object_type(file_, path) != H5O_TYPE_DATASET) continue;
        const Handle dataset(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), "HDF5 cannot open its dataset " + path);
        for (std::string& other : other_files(dataset, path_)) {
          if (std::ranges::find(files, other) == files.end() && std::filesystem::exists(other))
            files.push_back(std::move(other));
        }
      }
    }
  }

  std::string path_;
  Handle file_;
  std::vector<Source> sources_;
};

std::unique_ptr<isoextract_plugin::VolumeFile> open_file(const Request& request, const isoextract_plugin_host& host) {
  const std::scoped_lock lock(library_mutex());
  prepare_library();
  return std::make_unique<Hdf5File>(request, host);
}

bool probe_file(const unsigned char* start, std::size_t bytes, const std::string& /*path*/) {
  constexpr std::array<unsigned char, 8> kSignature{0x89, 'H', 'D', 'F', '\r', '\n', 0x1A, '\n'};
  const auto is_at = [&](std::size_t offset) {
    return bytes >= offset + kSignature.size() && std::equal(kSignature.begin(), kSignature.end(), start + offset);
  };
  return is_at(0) || is_at(512);
}

}  // namespace
}  // namespace isoextract_hdf5

const isoextract_volume_plugin_v4* isoextract_volume_plugin() {
  static const isoextract_volume_plugin_v4 table =
      isoextract_plugin::volume_plugin<isoextract_hdf5::open_file, isoextract_hdf5::probe_file>("hdf5", "HDF5");
  return &table;
}

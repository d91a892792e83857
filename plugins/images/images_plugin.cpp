// The plug-in: opens a file by its content, or several files of one picture each as the slices of a volume.
#include <filesystem>
#include <fstream>

#include "images.hpp"

namespace isoextract_plugin {

std::uint64_t file_size_of(const std::string& path) {
  std::error_code problem;
  const std::uintmax_t size = std::filesystem::file_size(path, problem);
  if (problem) throw ReadError("expected a readable file: " + problem.message());
  return size;
}

std::uint64_t checked_product(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 62;
  if (a != 0 && b > kMost / a) throw ReadError("the header states more than 2^62 bytes of samples");
  return a * b;
}

void check_file_holds(std::uint64_t file_size, std::uint64_t sample_bytes, std::uint64_t ratio) {
  if (sample_bytes / ratio <= file_size) return;
  throw ReadError("the header states " + std::to_string(sample_bytes) + " bytes of samples, but the file has " +
                  std::to_string(file_size) + " bytes" +
                  (ratio == 1 ? "" : ", fewer than its compression can make of them"));
}

std::string dims_text(const Grid& grid) {
  return std::to_string(grid.dims[0]) + " x " + std::to_string(grid.dims[1]) + " " + grid.type_name;
}

namespace {

std::string file_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }

std::unique_ptr<VolumeFile> open_one(const std::string& path, const RgbRule& rule, const isoextract_plugin_host& host) {
  std::ifstream file(path, std::ios::binary);
  unsigned char start[8] = {};
  file.read(reinterpret_cast<char*>(start), sizeof start);
  const auto bytes = static_cast<std::size_t>(file.gcount());
  if (bytes == 0) throw ReadError("expected an image, found an empty or unreadable file");
  file.close();
  if (is_tiff(start, bytes)) return open_tiff(path, host);
  if (is_exr(start, bytes)) return open_exr(path, rule, host);
  if (is_png(start, bytes)) return open_png(path, host);
  throw ReadError("expected a TIFF, OpenEXR or PNG image, found other content");
}

// Throws unless the file is a single picture.
void check_is_slice(const VolumeFile& file, const std::string& path) {
  for (const Grid& grid : file.grids) {
    if (grid.dims[2] == 1 && grid.volumes == 1) continue;
    throw ReadError("expected one picture in each file of a stack, found " +
                    std::to_string(grid.dims[2] * grid.volumes) + " in " + file_name(path));
  }
}

// Pictures of the same size in several files, each a slice.
class Stack final : public VolumeFile {
 public:
  Stack(const std::vector<std::string>& paths, const isoextract_plugin_host& host) : paths_(paths) {
    RgbRule compare;
    for (std::size_t i : {paths.size() / 2, paths.size() - 1}) compare.compared.push_back(paths[i]);
    const auto first = open_one(paths.front(), compare, host);
    check_is_slice(*first, paths.front());
    format = first->format + " slices";
    creator = first->creator;
    note = std::to_string(paths.size()) + " files are the slices of one volume" +
           (first->note.empty() ? "" : "; " + first->note);
    grids = first->grids;
    for (std::size_t i = 1; i < paths.size(); ++i) {
      check_cancelled(host);
      static_cast<void>(open_slice(i, host));
      files.push_back(paths[i]);
    }
    for (Grid& grid : grids) grid.dims[2] = paths.size();
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    const Grid& grid = grids[selection.grid];
    const std::uint64_t slice_bytes =
        selection.count[0] * selection.count[1] * sample_size(selected_type(grid, selection));
    ReadFacts facts;
    std::uint64_t told = 0;
    for (std::uint64_t z = 0; z < selection.count[2]; ++z) {
      check_cancelled(host);
      const auto i = static_cast<std::size_t>(selection.first[2] + z);
      isoextract_volume_selection part = selection;
      part.first[2] = 0;
      part.count[2] = 1;
      part.box = static_cast<char*>(selection.box) + z * slice_bytes;
      const ReadFacts slice = read_slice(i, part, host);
      if (!slice.note.empty() && told++ == 0) facts.note = file_name(paths_[i]) + ": " + slice.note;
    }
    if (told > 1) facts.note += "; " + std::to_string(told) + " slices have such notes";
    facts.parts_read = selection.count[2];
    facts.parts = paths_.size();
    return facts;
  }

 private:
  // Opens a slice, which must have the first one's grids.
  std::unique_ptr<VolumeFile> open_slice(std::size_t i, const isoextract_plugin_host& host) const {
    std::unique_ptr<VolumeFile> slice;
    try {
      slice = open_one(paths_[i], {{}, grids.size() == 1 && grids.front().name == "R"}, host);
    } catch (const ReadError& error) {
      throw ReadError(file_name(paths_[i]) + ": " + error.what());
    }
    check_is_slice(*slice, paths_[i]);
    for (std::size_t g = 0; g < std::max(grids.size(), slice->grids.size()); ++g) {
      const std::string expected = g < grids.size() ? named_dims(grids[g]) : "no more images";
      const std::string found = g < slice->grids.size() ? named_dims(slice->grids[g]) : "no more images";
      if (expected == found) continue;
      throw ReadError(file_name(paths_[i]) + " differs from the first slice, " + file_name(paths_.front()) +
                      ": expected " + expected + ", found " + found);
    }
    return slice;
  }

  ReadFacts read_slice(std::size_t i, const isoextract_volume_selection& part,
                       const isoextract_plugin_host& host) const {
    const auto slice = open_slice(i, host);
    try {
      return slice->read(part, host);
    } catch (const ReadError& error) {
      throw ReadError(file_name(paths_[i]) + ": " + error.what());
    }
  }

  static std::string named_dims(const Grid& grid) {
    std::string text = dims_text(grid);
    if (grid.components > 1) text += " with " + std::to_string(grid.components) + " components";
    return grid.name.empty() ? text : "'" + grid.name + "' of " + text;
  }

  std::vector<std::string> paths_;
};

std::unique_ptr<VolumeFile> open_images(const Request& request, const isoextract_plugin_host& host) {
  if (request.files.size() > 1) return std::make_unique<Stack>(request.files, host);
  return open_one(request.path, {}, host);
}

bool may_be_image(const unsigned char* start, std::size_t bytes, const std::string& /*path*/) {
  return is_tiff(start, bytes) || is_exr(start, bytes) || is_png(start, bytes);
}

}  // namespace
}  // namespace isoextract_plugin

const isoextract_volume_plugin_v4* isoextract_volume_plugin(void) {
  static const isoextract_volume_plugin_v4 table =
      isoextract_plugin::volume_plugin<isoextract_plugin::open_images, isoextract_plugin::may_be_image>("images",
                                                                                                        "image");
  return &table;
}

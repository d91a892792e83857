// Layouts with several resolutions: Imaris and BigDataViewer.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <system_error>

#include "hdf5_parts.hpp"

namespace isoextract_hdf5 {
namespace {

constexpr std::size_t kMostTimePoints = 1000000;

void check_level(std::uint64_t level, std::uint64_t levels) {
  if (level >= levels) {
    throw ReadError("expected a level from 0 to " + std::to_string(levels - 1) + ", found " + std::to_string(level));
  }
}

// Imaris stores numbers as texts.
double text_number(hid_t object, const char* name) {
  const std::string text = attribute_text(object, name);
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || end == text.c_str() || !std::isfinite(value))
    throw ReadError(std::string("expected a number in Imaris's attribute ") + name + ", found '" + text + "'");
  return value;
}

std::uint64_t text_size(hid_t object, const char* name) {
  const double value = text_number(object, name);
  if (!(value >= 1 && value < 0x1p31))
    throw ReadError(std::string("expected a size in Imaris's attribute ") + name + ", found " +
                    attribute_text(object, name));
  return static_cast<std::uint64_t>(value);
}

// Counts PREFIX0, PREFIX1, ... in a group.
std::uint64_t count_numbered(hid_t file, const std::string& prefix) {
  std::uint64_t count = 0;
  while (count < kMostTimePoints && object_type(file, prefix + std::to_string(count)) != H5O_TYPE_UNKNOWN) ++count;
  return count;
}

// Converts "2010-01-31 23:59:59.500" to seconds since 1970, without a time zone; nullopt for other text.
std::optional<double> seconds_of(const std::string& text) {
  int year = 0;
  int month = 0;
  int day = 0;
  int hour = 0;
  int minute = 0;
  double second = 0;
  if (std::sscanf(text.c_str(), "%d-%d-%d %d:%d:%lf", &year, &month, &day, &hour, &minute, &second) != 6)
    return std::nullopt;
  if (year < 1 || year > 9999 || month < 1 || month > 12 || day < 1 || day > 31) return std::nullopt;
  // Days of the Gregorian calendar, with years from March on (Howard Hinnant, chrono-Compatible Low-Level Date
  // Algorithms, 2013).
  const int y = month <= 2 ? year - 1 : year;
  const int era = y / 400;
  const int year_of_era = y - era * 400;
  const int day_of_year = (153 * (month > 2 ? month - 3 : month + 9) + 2) / 5 + day - 1;
  const int days = era * 146097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719468;
  return days * 86400.0 + hour * 3600.0 + minute * 60.0 + second;
}

std::vector<double> imaris_times(hid_t file, std::uint64_t count) {
  const auto info = find_object(file, "/DataSetInfo/TimeInfo");
  if (!info) return {};
  std::vector<double> times;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto time = seconds_of(attribute_text(*info, ("TimePoint" + std::to_string(i + 1)).c_str()));
    if (!time) return {};
    times.push_back(*time);
  }
  for (std::size_t i = times.size(); i-- > 0;) times[i] -= times[0];
  return times;
}

// The extent of the image covers whole voxels; samples are at their centers.
void place_imaris(hid_t image, Grid& grid) {
  constexpr std::array<const char*, 3> kMin{"ExtMin0", "ExtMin1", "ExtMin2"};
  constexpr std::array<const char*, 3> kMax{"ExtMax0", "ExtMax1", "ExtMax2"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double least = text_number(image, kMin[axis]);
    const double spacing = (text_number(image, kMax[axis]) - least) / static_cast<double>(grid.dims[axis]);
    grid.index_to_world[4 * axis + axis] = spacing;
    grid.index_to_world[4 * axis + 3] = least + spacing / 2;
  }
  grid.length_unit = attribute_text(image, "Unit");
}

// Sets the type and shape of a grid whose volumes are datasets of z, y, x.
bool describe_volumes(hid_t file, Grid& grid, Source& source) {
  const Handle dataset(H5Dopen2(file, source.paths[0].c_str(), H5P_DEFAULT),
                       "HDF5 cannot open its dataset " + source.paths[0]);
  source.shape = describe_dataset(dataset, grid);
  if (source.shape.size() != 3) return false;
  source.axis = {2, 1, 0};
  grid.dims = {source.shape[2], source.shape[1], source.shape[0]};
  grid.volumes = source.paths.size();
  return true;
}

// Returns the text of the first element with this tag; "" if there is none. Expects no nested element of this tag.
std::string xml_element(const std::string& text, const std::string& tag) {
  const std::size_t open = text.find("<" + tag + ">");
  const std::size_t close = open == std::string::npos ? open : text.find("</" + tag + ">", open);
  if (close == std::string::npos) return {};
  const std::size_t start = open + tag.size() + 2;
  return text.substr(start, close - start);
}

// The size of a voxel, as the XML file beside a BigDataViewer file states it.
struct VoxelSize {
  std::array<double, 3> size{};
  std::string unit;
};

std::optional<VoxelSize> find_voxel_size(const std::string& xml, unsigned setup) {
  for (std::size_t at = xml.find("<ViewSetup>"); at != std::string::npos; at = xml.find("<ViewSetup>", at + 1)) {
    const std::string element = xml_element(xml.substr(at), "ViewSetup");
    if (xml_element(element, "id") != std::to_string(setup)) continue;
    const std::string voxel = xml_element(element, "voxelSize");
    VoxelSize found;
    found.unit = xml_element(voxel, "unit");
    std::istringstream numbers(xml_element(voxel, "size"));
    numbers >> found.size[0] >> found.size[1] >> found.size[2];
    const bool is_valid = !numbers.fail() && std::ranges::all_of(found.size, [](double size) { return size > 0; });
    return is_valid ? std::optional(found) : std::nullopt;
  }
  return std::nullopt;
}

std::string xml_path(const std::string& path) { return std::filesystem::path(path).replace_extension(".xml").string(); }

// Returns the text of a file; "" if it cannot be read or has more than 16 MiB.
std::string read_text(const std::string& path) {
  constexpr std::uintmax_t kMostBytes = std::uintmax_t{1} << 24;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size > kMostBytes) return {};
  std::string text(static_cast<std::size_t>(size), '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  return in ? text : std::string();
}

}  // namespace

std::optional<Contents> list_imaris(hid_t file, const Request& request) {
  const auto image = find_object(file, "/DataSetInfo/Image");
  if (!image || object_type(file, "/DataSet/ResolutionLevel 0/TimePoint 0") != H5O_TYPE_GROUP) return std::nullopt;
  Contents contents;
  contents.format = "Imaris";
  contents.levels = count_numbered(file, "/DataSet/ResolutionLevel ");
  check_level(request.level, contents.levels);
  const std::string level = "/DataSet/ResolutionLevel " + std::to_string(request.level) + "/TimePoint ";
  const std::uint64_t times = count_numbered(file, level);
  const std::uint64_t channels = count_numbered(file, level + "0/Channel ");
  if (times == 0 || channels == 0) throw ReadError("expected time points and channels of Imaris, found none");
  std::map<std::string, int> names;
  for (std::uint64_t channel = 0; channel < channels; ++channel) {
    const std::string number = std::to_string(channel);
    const auto group = find_object(file, level + "0/Channel " + number);
    Grid grid;
    if (const auto info = find_object(file, "/DataSetInfo/Channel " + number))
      grid.name = attribute_text(*info, "Name");
    if (grid.name.empty() || names[grid.name]++ > 0) grid.name = "Channel " + number;
    Source source;
    for (std::uint64_t time = 0; time < times; ++time)
      source.paths.push_back(level + std::to_string(time) + "/Channel " + number + "/Data");
    if (object_type(file, source.paths[0]) != H5O_TYPE_DATASET || !describe_volumes(file, grid, source))
      throw ReadError("expected samples of three dimensions in Imaris's channel " + number);
    // Data is padded to whole chunks.
    const std::array<std::uint64_t, 3> dims{text_size(*group, "ImageSizeX"), text_size(*group, "ImageSizeY"),
                                            text_size(*group, "ImageSizeZ")};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (dims[axis] > grid.dims[axis])
        throw ReadError("expected at least " + std::to_string(dims[axis]) + " samples along an axis of Imaris's " +
                        "channel " + number + ", found " + std::to_string(grid.dims[axis]));
    }
    grid.dims = dims;
    place_imaris(*image, grid);
    grid.volume_times = imaris_times(file, times);
    if (!grid.volume_times.empty()) grid.time_unit = "s";
    contents.add(std::move(grid), std::move(source));
  }
  return contents;
}

std::optional<Contents> list_bigdataviewer(hid_t file, const Request& request) {
  char name[16] = "";
  const auto setup_name = [&](unsigned setup) {
    std::snprintf(name, sizeof name, "/s%02u", setup);
    return std::string(name);
  };
  const auto time_name = [&](unsigned time) {
    std::snprintf(name, sizeof name, "/t%05u", time);
    return std::string(name);
  };
  if (object_type(file, "/s00/resolutions") != H5O_TYPE_DATASET) return std::nullopt;
  Contents contents;
  contents.format = "BigDataViewer HDF5";
  const std::string xml = read_text(xml_path(request.path));
  if (!xml.empty()) contents.files.push_back(xml_path(request.path));
  for (unsigned setup = 0; setup < 100 && object_type(file, setup_name(setup)) != H5O_TYPE_UNKNOWN; ++setup) {
    const auto factors = dataset_numbers(file, setup_name(setup) + "/resolutions");
    const std::uint64_t levels = factors.size() / 3;
    if (levels == 0) throw ReadError("expected three factors for each level in " + setup_name(setup) + "/resolutions");
    check_level(request.level, levels);
    contents.levels = std::max(contents.levels, levels);
    Grid grid;
    Source source;
    for (unsigned time = 0; time < 100000; ++time) {
      const std::string path = time_name(time) + setup_name(setup) + "/" + std::to_string(request.level) + "/cells";
      if (object_type(file, path) != H5O_TYPE_DATASET) break;
      source.paths.push_back(path);
    }
    if (source.paths.empty() || !describe_volumes(file, grid, source)) continue;
    grid.name = setup_name(setup).substr(1);
    const auto voxel = find_voxel_size(xml, setup);
    grid.has_placement = voxel.has_value();
    if (voxel) grid.length_unit = voxel->unit;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double size = voxel ? voxel->size[axis] : 1;
      const double factor = factors[3 * request.level + axis];
      grid.index_to_world[4 * axis + axis] = size * factor;
      grid.index_to_world[4 * axis + 3] = size * (factor - 1) / 2;  // a voxel of a level covers whole voxels of level 0
      grid.has_placement = grid.has_placement || factor != 1;
    }
    source.note = voxel ? "the reader takes the spacing from the XML file, and ignores the registrations in it"
                        : "lengths are voxels of level 0, because no XML file beside it states the spacing";
    contents.add(std::move(grid), std::move(source));
  }
  return contents;
}

}  // namespace isoextract_hdf5

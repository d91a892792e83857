// How the pages of a TIFF form volumes: ImageJ's description, GeoTIFF's tags, or just one page after another.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <span>

#include "images_tiff.hpp"

namespace isoextract_plugin {
namespace {

constexpr std::uint32_t kModelPixelScale = 33550;
constexpr std::uint32_t kModelTiepoint = 33922;
constexpr std::uint32_t kModelTransformation = 34264;
constexpr std::uint32_t kGeoKeys = 34735;
constexpr std::uint32_t kGdalNoData = 42113;

// Values of a tag that libtiff has no definition of: a count and an array of the file's type.
struct TagValues {
  std::uint64_t count = 0;
  const void* data = nullptr;
};

TagValues values_of(const Tiff& tiff, std::uint32_t tag, TIFFDataType type) {
  const TIFFField* const field = TIFFFindField(tiff.get(), tag, TIFF_ANY);
  if (field == nullptr || TIFFFieldDataType(field) != type || TIFFFieldPassCount(field) == 0) return {};
  const void* data = nullptr;
  if (TIFFFieldReadCount(field) == TIFF_VARIABLE2) {
    std::uint32_t count = 0;
    if (TIFFGetField(tiff.get(), tag, &count, &data) == 0) return {};
    return {count, data};
  }
  std::uint16_t count = 0;
  if (TIFFGetField(tiff.get(), tag, &count, &data) == 0) return {};
  return {count, data};
}

std::span<const double> doubles_of(const Tiff& tiff, std::uint32_t tag) {
  const TagValues values = values_of(tiff, tag, TIFF_DOUBLE);
  return {static_cast<const double*>(values.data), values.data == nullptr ? 0 : values.count};
}

bool are_finite(std::span<const double> values) {
  return std::ranges::all_of(values, [](double v) { return std::isfinite(v); });
}

// Returns the value of a key of GeoTIFF's directory, or nothing.
std::optional<int> geo_key(const Tiff& tiff, int wanted) {
  const TagValues keys = values_of(tiff, kGeoKeys, TIFF_SHORT);
  const auto* const entries = static_cast<const std::uint16_t*>(keys.data);
  for (std::uint64_t i = 4; entries != nullptr && i + 4 <= keys.count; i += 4) {
    if (entries[i] == wanted && entries[i + 1] == 0) return entries[i + 3];
  }
  return std::nullopt;
}

// Returns GeoTIFF's transform from raster to map coordinates, if the file states one.
std::optional<std::array<double, 12>> map_transform(const Tiff& tiff) {
  const auto matrix = doubles_of(tiff, kModelTransformation);
  if (matrix.size() >= 16 && are_finite(matrix)) {
    std::array<double, 12> map{};
    std::copy_n(matrix.begin(), 12, map.begin());
    if (map[2] == 0 && map[6] == 0 && map[10] == 0) map[10] = 1;
    return map;
  }
  const auto scale = doubles_of(tiff, kModelPixelScale);
  const auto tie = doubles_of(tiff, kModelTiepoint);
  if (scale.size() < 2 || tie.size() < 6 || !are_finite(scale) || !are_finite(tie)) return std::nullopt;
  if (!(scale[0] > 0) || !(scale[1] > 0)) return std::nullopt;
  const double z = scale.size() > 2 && scale[2] > 0 ? scale[2] : 1;
  return std::array<double, 12>{scale[0], 0, 0, tie[3] - tie[0] * scale[0], 0, -scale[1], 0, tie[4] + tie[1] * scale[1],
                                0,        0, z, tie[5] - tie[2] * z};
}

// Places a series by GeoTIFF's tags. Rows usually go south, so that y decreases with the row.
void place_on_map(const Tiff& tiff, Series& series, Layout& layout) {
  auto map = map_transform(tiff);
  if (!map) return;
  constexpr int kRasterType = 1025;
  constexpr int kModelType = 1024;
  constexpr int kLinearUnit = 3076;
  constexpr int kPixelIsPoint = 2;
  constexpr int kGeographic = 2;
  if (geo_key(tiff, kRasterType) != kPixelIsPoint) {
    for (std::size_t row = 0; row < 3; ++row) (*map)[4 * row + 3] += ((*map)[4 * row] + (*map)[4 * row + 1]) / 2;
  }
  layout.format = "GeoTIFF";
  series.has_placement = true;
  series.index_to_world = *map;
  if (geo_key(tiff, kModelType) == kGeographic) {
    layout.add_note("x and y are degrees of longitude and latitude");
    return;
  }
  switch (geo_key(tiff, kLinearUnit).value_or(0)) {
    case 9001: series.length_unit = "m"; break;
    case 9002: series.length_unit = "ft"; break;
    case 9003: series.length_unit = "US survey foot"; break;
    case 9036: series.length_unit = "km"; break;
    default: break;
  }
}

using Entries = std::map<std::string, std::string>;

// Splits lines of NAME=VALUE.
Entries entries_of(const std::string& text) {
  Entries entries;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    if (const std::size_t equal = line.find('='); equal != std::string::npos) {
      entries.emplace(line.substr(0, equal), line.substr(equal + 1));
    }
    at = end + 1;
  }
  return entries;
}

double number_in(const Entries& entries, const std::string& name, double otherwise) {
  const auto found = entries.find(name);
  if (found == entries.end()) return otherwise;
  const double value = std::strtod(found->second.c_str(), nullptr);
  return std::isfinite(value) ? value : otherwise;
}

std::uint64_t count_in(const Entries& entries, const std::string& name) {
  const double value = number_in(entries, name, 1);
  if (!(value >= 1) || value > 1e9) throw ReadError("ImageJ's description states '" + name + "' as no valid number");
  return static_cast<std::uint64_t>(value);
}

// Returns the size of a pixel along x or y from the tag's resolution in pixels per unit; 0 if there is none.
double pixel_size(const Tiff& tiff, std::uint32_t tag) {
  float resolution = 0;
  if (TIFFGetField(tiff.get(), tag, &resolution) == 0 || !(resolution > 0) || !std::isfinite(resolution)) return 0;
  return 1 / static_cast<double>(resolution);
}

// Placement and scale by ImageJ's calibration.
void calibrate(const Tiff& tiff, const Entries& entries, Series& series, Layout& layout) {
  const auto unit = entries.find("unit");
  const double x = pixel_size(tiff, TIFFTAG_XRESOLUTION);
  const double y = pixel_size(tiff, TIFFTAG_YRESOLUTION);
  const bool has_slices = series.sizes[0] > 1;
  if (unit != entries.end() && x > 0 && y > 0) {
    series.length_unit = known_unit(unit->second);
    series.has_placement = true;
  } else if (entries.contains("spacing")) {
    series.has_placement = true;
  }
  if (series.has_placement) {
    const bool sized = unit != entries.end() && x > 0 && y > 0;
    const double z = number_in(entries, "spacing", 0);
    const std::array<double, 3> size{sized ? x : 1, sized ? y : 1, z > 0 ? z : 1};
    if (!(z > 0) && has_slices)
      layout.add_note("the file states no distance between slices: the reader takes 1, as ImageJ does");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double origin = number_in(entries, std::string(1, "xyz"[axis]) + "origin", 0);
      series.index_to_world[5 * axis] = size[axis];
      series.index_to_world[4 * axis + 3] = origin == 0 ? 0 : -origin * size[axis];
    }
  }
  if (const auto function = entries.find("cf"); function != entries.end()) {
    const double slope = number_in(entries, "c1", 1);
    if (function->second == "0" && slope != 0) {
      series.slope = slope;
      series.intercept = number_in(entries, "c0", 0);
    } else {
      layout.add_note("the reader ignores the calibration of values: it is not linear, or its slope is 0");
    }
  }
  series.time_step = number_in(entries, "finterval", 0);
  series.time_unit = "s";
  if (const auto named = entries.find("tunit"); named != entries.end()) series.time_unit = named->second;
}

}  // namespace

std::string known_unit(std::string text) {
  static const std::map<std::string, std::string> names{
      {"\\u00B5m", "um"}, {"\\u00b5m", "um"}, {"\xC2\xB5m", "um"}, {"\xCE\xBCm", "um"},
      {"\xB5m", "um"},    {"micron", "um"},   {"microns", "um"},   {"\xC3\x85", "angstrom"},
      {"inch", "in"},     {"pixel", ""},      {"pixels", ""},      {"reference frame", ""}};
  while (text.ends_with('\r') || text.ends_with(' ')) text.pop_back();
  const auto found = names.find(text);
  return found == names.end() ? text : found->second;
}

std::optional<double> no_data_of(const Tiff& tiff) {
  const TagValues values = values_of(tiff, kGdalNoData, TIFF_ASCII);
  if (values.data == nullptr || values.count == 0) return std::nullopt;
  const std::string text(static_cast<const char*>(values.data), values.count);
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return end == text.c_str() || std::isnan(value) ? std::nullopt : std::optional(value);
}

std::optional<Layout> imagej_layout(Tiff& tiff, const std::string& text, std::vector<Page>& pages) {
  if (!text.starts_with("ImageJ=")) return std::nullopt;
  const Entries entries = entries_of(text);
  Layout layout;
  layout.format = "ImageJ TIFF";
  Series series;
  const std::uint64_t images = count_in(entries, "images");
  series.sizes = {count_in(entries, "slices"), count_in(entries, "channels"), count_in(entries, "frames")};
  if (checked_product(checked_product(series.sizes[0], series.sizes[1]), series.sizes[2]) != images) {
    series.sizes = {images, 1, 1};
  }
  const PageShape shape = pages.front().shape;
  std::erase_if(pages, [](const Page& page) { return page.is_reduced; });
  if (pages.empty()) throw ReadError("expected an image, found only reduced copies");
  if (pages.size() == 1 && images > 1) {  // more than 4 GiB: the other planes follow the first one
    std::uint16_t compression = COMPRESSION_NONE;
    TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_COMPRESSION, &compression);
    const std::uint64_t plane =
        checked_product(checked_product(shape.width, shape.height), std::uint64_t{shape.samples} * shape.bits) / 8;
    const std::uint64_t first = TIFFGetStrileOffset(tiff.get(), 0);
    if (compression != COMPRESSION_NONE || shape.bits % 8 != 0 || TIFFIsTiled(tiff.get()) != 0) {
      throw ReadError("expected " + std::to_string(images) + " pages by ImageJ's description, found one");
    }
    const std::uint64_t most = tiff.file_size() > first ? (tiff.file_size() - first) / plane : 0;
    if (images > most) {
      throw ReadError("expected " + std::to_string(images) + " planes by ImageJ's description, found room for " +
                      std::to_string(most));
    }
    for (std::uint64_t i = 1; i < images; ++i) {
      Page page = pages.front();
      page.plane = first + i * plane;
      pages.push_back(page);
    }
  }
  if (pages.size() != images) {
    throw ReadError("expected " + std::to_string(images) + " pages by ImageJ's description, found " +
                    std::to_string(pages.size()));
  }
  // Channels change fastest, then slices, then times.
  const auto [slices, channels, times] = series.sizes;
  for (std::uint64_t t = 0; t < times; ++t) {
    for (std::uint64_t c = 0; c < channels; ++c) {
      for (std::uint64_t z = 0; z < slices; ++z) series.pages.push_back((t * slices + z) * channels + c);
    }
  }
  calibrate(tiff, entries, series, layout);
  layout.series.push_back(std::move(series));
  return layout;
}

Layout plain_layout(Tiff& tiff, const std::vector<Page>& pages) {
  Layout layout;
  std::vector<PageShape> shapes;
  for (std::size_t i = 0; i < pages.size(); ++i) {
    const PageShape& shape = pages[i].shape;
    if (pages[i].is_reduced) continue;
    const auto found = std::ranges::find(shapes, shape);
    if (found == shapes.end()) {
      shapes.push_back(shape);
      layout.series.emplace_back().name =
          std::to_string(shape.width) + "x" + std::to_string(shape.height) + " " + type_of(shape).name;
    }
    Series& series = layout.series[static_cast<std::size_t>(std::ranges::find(shapes, shape) - shapes.begin())];
    series.pages.push_back(i);
    series.sizes[0] = series.pages.size();
  }
  if (layout.series.empty()) throw ReadError("expected an image, found only reduced copies or masks");
  place_on_map(tiff, layout.series.front(), layout);
  return layout;
}

}  // namespace isoextract_plugin

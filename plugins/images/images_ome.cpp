// OME-XML (2016-06 schema) in a TIFF's first description: sizes, order of the planes, physical sizes, channels' names.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>

#include "images_tiff.hpp"

namespace isoextract_plugin {
namespace {

// A start tag, without its namespace prefix.
struct Element {
  std::string name;
  std::map<std::string, std::string> attributes;

  [[nodiscard]] std::string text(const std::string& attribute) const {
    const auto found = attributes.find(attribute);
    return found == attributes.end() ? "" : found->second;
  }
  [[nodiscard]] double number(const std::string& attribute, double otherwise) const {
    const std::string value = text(attribute);
    double parsed = 0;
    const auto [end, problem] = std::from_chars(value.data(), value.data() + value.size(), parsed);
    return problem == std::errc() && std::isfinite(parsed) ? parsed : otherwise;
  }
  [[nodiscard]] std::uint64_t count(const std::string& attribute, std::uint64_t otherwise) const {
    const double value = number(attribute, static_cast<double>(otherwise));
    if (value < 0 || value > 1e9) throw ReadError("OME-XML states " + attribute + " as no valid number");
    return static_cast<std::uint64_t>(value);
  }
};

std::string decoded(std::string_view text) {
  static const std::map<std::string_view, std::string_view> entities{
      {"amp", "&"},  {"lt", "<"},          {"gt", ">"},         {"quot", "\""},
      {"apos", "'"}, {"#181", "\xC2\xB5"}, {"#xB5", "\xC2\xB5"}};
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::size_t end = text[i] == '&' ? text.find(';', i) : std::string_view::npos;
    const auto found = end == std::string_view::npos ? entities.end() : entities.find(text.substr(i + 1, end - i - 1));
    if (found == entities.end()) {
      out += text[i];
    } else {
      out += found->second;
      i = end;
    }
  }
  return out;
}

// Returns the attributes of a tag. `tag`: its text after the name.
std::map<std::string, std::string> attributes_of(std::string_view tag) {
  std::map<std::string, std::string> attributes;
  constexpr std::string_view kSpace = " \t\r\n";
  std::size_t at = 0;
  while ((at = tag.find_first_not_of(kSpace, at)) != std::string_view::npos) {
    const std::size_t equal = tag.find('=', at);
    if (equal == std::string_view::npos) break;
    const std::size_t quote = tag.find_first_of("\"'", equal);
    if (quote == std::string_view::npos) break;
    const std::size_t end = tag.find(tag[quote], quote + 1);
    if (end == std::string_view::npos) break;
    std::string_view name = tag.substr(at, equal - at);
    name = name.substr(0, name.find_last_not_of(kSpace) + 1);
    attributes.emplace(name, decoded(tag.substr(quote + 1, end - quote - 1)));
    at = end + 1;
  }
  return attributes;
}

// Returns the start tags in order.
std::vector<Element> elements_of(std::string_view xml) {
  std::vector<Element> elements;
  for (std::size_t at = 0; (at = xml.find('<', at)) != std::string_view::npos;) {
    if (xml.substr(at).starts_with("<!--")) {
      const std::size_t end = xml.find("-->", at);
      if (end == std::string_view::npos) break;
      at = end;
      continue;
    }
    const std::size_t end = xml.find('>', at);
    if (end == std::string_view::npos) break;
    const std::string_view tag = xml.substr(at + 1, end - at - 1);
    at = end;
    if (tag.empty() || tag[0] == '/' || tag[0] == '?' || tag[0] == '!') continue;
    std::string_view name = tag.substr(0, tag.find_first_of(" \t\r\n/"));
    const std::size_t length = name.size();
    if (const std::size_t colon = name.find(':'); colon != std::string_view::npos) name = name.substr(colon + 1);
    elements.push_back({std::string(name), attributes_of(tag.substr(length))});
  }
  return elements;
}

// Meters in a unit of lengths; 0: unknown.
double meters_of(const std::string& unit) {
  static const std::map<std::string, double> known{{"m", 1},     {"cm", 1e-2},  {"mm", 1e-3},        {"um", 1e-6},
                                                   {"nm", 1e-9}, {"pm", 1e-12}, {"angstrom", 1e-10}, {"in", 0.0254}};
  const auto found = known.find(unit);
  return found == known.end() ? 0 : found->second;
}

// Sets the placement by the physical sizes, in the unit of x.
void place(const Element& pixels, Series& series, Layout& layout) {
  if (pixels.text("PhysicalSizeX").empty()) return;
  std::array<double, 3> sizes{1, 1, 1};
  std::array<std::string, 3> units;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name = std::string("PhysicalSize") + "XYZ"[axis];
    const double size = pixels.number(name, 0);
    const std::string unit = pixels.text(name + "Unit");
    units[axis] = known_unit(unit.empty() ? "um" : unit);
    if (size > 0) {
      sizes[axis] = size;
    } else if (axis < 2 || series.sizes[0] > 1) {
      layout.add_note("the file states no valid " + name + ": the reader takes 1");
      units[axis] = units[0];
    }
    if (units[axis] == units[0]) continue;
    const double ratio = meters_of(units[axis]) / meters_of(units[0]);
    if (std::isfinite(ratio) && ratio > 0) {
      sizes[axis] *= ratio;
    } else {
      layout.add_note("the reader cannot convert the unit of " + name + ", '" + units[axis] +
                      "', to that of PhysicalSizeX");
    }
  }
  series.has_placement = true;
  series.length_unit = units[0];
  for (std::size_t axis = 0; axis < 3; ++axis) series.index_to_world[5 * axis] = sizes[axis];
}

// Builds the series of one image from its elements, one after another.
class ImageBuilder {
 public:
  ImageBuilder(const Element& pixels, std::string name) : order_(pixels.text("DimensionOrder")) {
    series_.name = std::move(name);
    series_.sizes = {pixels.count("SizeZ", 1), pixels.count("SizeC", 1), pixels.count("SizeT", 1)};
    if (order_.size() != 5 || !order_.starts_with("XY")) order_ = "XYZCT";
    series_.time_step = pixels.number("TimeIncrement", 0);
    series_.time_unit = pixels.text("TimeIncrementUnit").empty() ? "s" : pixels.text("TimeIncrementUnit");
  }

  // Call when the channels are known, before the first plane. SizeC counts each sample of an RGB pixel as a channel.
  void start_planes(std::uint64_t samples, std::size_t pages) {
    if (!series_.pages.empty()) return;
    if (samples > 1 && series_.sizes[1] % samples == 0) series_.sizes[1] /= samples;
    const std::uint64_t planes = checked_product(checked_product(series_.sizes[0], series_.sizes[1]), series_.sizes[2]);
    if (planes == 0 || planes > pages) {
      throw ReadError("expected " + std::to_string(planes) + " pages by its OME-XML, found " + std::to_string(pages));
    }
    series_.pages.assign(planes, kNone);
  }

  // Assigns the pages from `page` on to `count` planes from (Z, C, T) = `first` on, in dimension order.
  void set_planes(const std::array<std::uint64_t, 3>& first, std::uint64_t page, std::uint64_t count,
                  std::size_t pages) {
    const std::uint64_t start = linear_of(first);
    for (std::uint64_t i = 0; i < count && start + i < series_.pages.size(); ++i) {
      if (page + i >= pages)
        throw ReadError("its OME-XML refers to page " + std::to_string(page + i) + " of " + std::to_string(pages));
      const auto [z, c, t] = place_of(start + i);
      series_.pages[(t * series_.sizes[1] + c) * series_.sizes[0] + z] = page + i;
    }
  }

  // Returns the series. Without any assigned page, page i is plane i; throws if only some planes have pages.
  Series finish(std::size_t pages) {
    start_planes(1, pages);
    if (std::ranges::all_of(series_.pages, [](std::size_t page) { return page == kNone; })) {
      set_planes({0, 0, 0}, 0, series_.pages.size(), pages);
    }
    const auto missing = std::ranges::count(series_.pages, kNone);
    if (missing > 0) throw ReadError("its OME-XML names no page for " + std::to_string(missing) + " of its planes");
    return std::move(series_);
  }

  Series& series() { return series_; }

 private:
  static constexpr auto kNone = static_cast<std::size_t>(-1);

  // Returns the axes Z, C and T as 0, 1 and 2, the fastest first.
  [[nodiscard]] std::array<std::size_t, 3> axes() const {
    std::array<std::size_t, 3> axes{0, 1, 2};
    for (std::size_t i = 0; i < 3; ++i) axes[i] = std::string_view("ZCT").find(order_[2 + i]) % 3;
    return axes;
  }
  [[nodiscard]] std::uint64_t linear_of(const std::array<std::uint64_t, 3>& place) const {
    const auto [a, b, c] = axes();
    return (place[c] * series_.sizes[b] + place[b]) * series_.sizes[a] + place[a];
  }
  [[nodiscard]] std::array<std::uint64_t, 3> place_of(std::uint64_t linear) const {
    std::array<std::uint64_t, 3> place{};
    for (const std::size_t axis : axes()) {
      place[axis] = linear % series_.sizes[axis];
      linear /= series_.sizes[axis];
    }
    return place;
  }

  Series series_;
  std::string order_;
};

}  // namespace

std::optional<Layout> ome_layout(const std::string& text, const std::vector<Page>& pages, const std::string& path) {
  if (text.substr(0, 4096).find("<OME") == std::string::npos &&
      text.substr(0, 4096).find(":OME") == std::string::npos) {
    return std::nullopt;
  }
  Layout layout;
  layout.format = "OME-TIFF";
  std::optional<ImageBuilder> builder;
  std::string image_name;
  std::uint64_t samples = 1;
  std::set<std::string> files;  // names of the files with planes, from UUID elements
  const auto finish = [&] {
    if (!builder) return;
    builder->start_planes(samples, pages.size());
    layout.series.push_back(builder->finish(pages.size()));
    builder.reset();
  };
  for (const Element& element : elements_of(text)) {
    if (element.name == "Image") {
      finish();
      image_name = element.text("Name").empty() ? element.text("ID") : element.text("Name");
    } else if (element.name == "Pixels") {
      finish();
      builder.emplace(element, image_name);
      place(element, builder->series(), layout);
      samples = 1;
    } else if (!builder) {
      continue;
    } else if (element.name == "Channel") {
      builder->series().channels.push_back(element.text("Name"));
      samples = std::max(samples, element.count("SamplesPerPixel", 1));
    } else if (element.name == "TiffData") {
      builder->start_planes(samples, pages.size());
      const bool has_page = !element.text("IFD").empty();
      builder->set_planes({element.count("FirstZ", 0), element.count("FirstC", 0), element.count("FirstT", 0)},
                          element.count("IFD", 0), element.count("PlaneCount", has_page ? 1 : pages.size()),
                          pages.size());
    } else if (element.name == "UUID" && !element.text("FileName").empty()) {
      files.insert(element.text("FileName"));
    }
  }
  finish();
  if (files.size() > 1) {
    throw ReadError("expected an image in one file, found OME-XML of planes in " + std::to_string(files.size()) +
                    " files: " + *files.begin() + ", " + *std::next(files.begin()) + (files.size() > 2 ? ", ..." : ""));
  }
  if (files.size() == 1 && *files.begin() != std::filesystem::path(path).filename().string()) {
    layout.add_note("the OME-XML calls this file " + *files.begin() + ": the reader takes all pages from this file");
  }
  if (layout.series.empty()) return std::nullopt;
  return layout;
}

}  // namespace isoextract_plugin

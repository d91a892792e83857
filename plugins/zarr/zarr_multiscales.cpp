// OME-Zarr: pyramids, their axes and transformations, channels, label images (NGFF 0.4 and 0.5; axes of 0.3 and
// before).
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "zarr_images.hpp"

namespace isoextract_zarr {
namespace {

constexpr double kMostColor = 255;

std::vector<Axis> axes_of(const Json& multiscale, std::size_t count) {
  using enum Axis::Kind;
  std::vector<Axis> axes(count);
  const Json& given = member(multiscale, "axes");
  if (!given.is_null() && (!given.is_array() || given.size() != count)) {
    throw ReadError(fmt::format("expected the names of {} axes, as many as the array has", count));
  }
  std::vector<std::size_t> open;  // spatial axes with other names than x, y and z
  const auto is_used = [&](Axis::Kind kind) { return std::ranges::find(axes, kind, &Axis::kind) != axes.end(); };
  for (std::size_t i = 0; i < given.size(); ++i) {
    Axis& axis = axes[i];
    axis.name = text_of(given[i].is_string() ? given[i] : member(given[i], "name"));
    axis.unit = text_of(member(given[i], "unit"));
    const std::string type = text_of(member(given[i], "type"));
    Axis::Kind kind = kind_called(axis.name);
    const bool is_spatial = kind == x || kind == y || kind == z;
    if (type == "time") kind = time;
    if (type == "channel") kind = channel;
    if (type == "space" && !is_spatial) {
      open.push_back(i);
      continue;
    }
    if (kind != other && !is_used(kind)) axis.kind = kind;
  }
  for (std::size_t i = open.size(); i-- > 0;) {
    for (const Axis::Kind kind : {x, y, z}) {
      if (axes[open[i]].kind == other && !is_used(kind)) axes[open[i]].kind = kind;
    }
  }
  if (given.is_null()) set_kinds_by_position(axes);
  return axes;
}

// Appends a list of coordinateTransformations to the image's transformations.
void apply_transformations(const Json& list, Image& image) {
  if (list.is_null()) return;
  if (!list.is_array()) throw ReadError("expected a list of coordinateTransformations");
  const std::size_t count = image.scale.size();
  for (const Json& entry : list) {
    const std::string type = text_of(member(entry, "type"));
    if (type == "identity") continue;
    if (type != "scale" && type != "translation") {
      throw ReadError(fmt::format("expected a transformation scale or translation, found '{}'", shown(type)));
    }
    const auto numbers = numbers_of(member(entry, type.c_str()), count);
    if (!numbers || (type == "scale" && std::ranges::find(*numbers, 0.0) != numbers->end())) {
      throw ReadError(
          fmt::format("expected a {} of {} finite numbers{}", type, count, type == "scale" ? " other than 0" : ""));
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (type == "scale") {
        image.scale[i] *= (*numbers)[i];
        image.translation[i] *= (*numbers)[i];
      } else {
        image.translation[i] += (*numbers)[i];
      }
    }
    image.has_placement = true;
  }
}

// Returns a label's value; nothing if it is no integer.
std::optional<std::int64_t> label_value(const Json& entry) {
  const Json& value = member(entry, "label-value");
  if (value.is_number_integer()) return value.get<std::int64_t>();
  const double number = value.is_number_float() ? value.get<double>() : 0.5;
  if (number != std::trunc(number) || std::abs(number) > 0x1p53) return std::nullopt;
  return static_cast<std::int64_t>(number);
}

std::vector<isoextract_plugin::Label> labels_of(const Json& image_label) {
  std::map<std::int64_t, isoextract_plugin::Label> labels;
  const auto label_at = [&](std::int64_t value) -> isoextract_plugin::Label& {
    auto& label = labels[value];
    label.value = value;
    return label;
  };
  for (const Json& entry : member(image_label, "colors")) {
    const auto value = label_value(entry);
    const Json& rgba = member(entry, "rgba");
    const auto color = numbers_of(rgba, rgba.size());
    if (!value || !color || color->size() < 3) continue;
    auto& label = label_at(*value);
    for (std::size_t i = 0; i < 3; ++i) label.color[i] = std::clamp((*color)[i] / kMostColor, 0.0, 1.0);
    label.has_color = true;
  }
  for (const Json& entry : member(image_label, "properties")) {
    const auto value = label_value(entry);
    if (!value) continue;
    // The specification does not define the key of a name.
    for (const char* key : {"name", "label", "class", "label-name"}) {
      if (const std::string name = text_of(member(entry, key)); !name.empty()) {
        label_at(*value).name = name;
        break;
      }
    }
  }
  std::vector<isoextract_plugin::Label> list;
  for (auto& [value, label] : labels) list.push_back(std::move(label));
  return list;
}

std::string level_list(Hierarchy& hierarchy, const std::string& group, const Json& datasets) {
  constexpr std::size_t kMostShown = 16;
  std::string text;
  for (std::size_t i = 0; i < std::min(datasets.size(), kMostShown); ++i) {
    std::string shape = "no array";
    try {
      const auto array = hierarchy.array(join(group, checked_path(text_of(member(datasets[i], "path")))));
      shape = fmt::format("{}", fmt::join(array.shape, " x "));
    } catch (const ReadError&) {
      // Listed as missing.
    }
    text += fmt::format("{}{}: {}", i == 0 ? "" : "; ", i, shape);
  }
  return text + (datasets.size() > kMostShown ? "; ..." : "");
}

}  // namespace

const Json& ome_of(const Node& node) {
  const Json& ome = member(node.attributes, "ome");
  return ome.is_object() ? ome : node.attributes;
}

Image read_multiscales(Hierarchy& hierarchy, const std::string& group, const Node& node, std::uint64_t level,
                       Images& found) {
  const Json& ome = ome_of(node);
  const Json& pyramids = member(ome, "multiscales");
  if (pyramids.empty()) throw ReadError("expected an image in multiscales, found none");
  const Json& pyramid = pyramids.front();
  if (pyramids.size() > 1) {
    found.notes.push_back(
        fmt::format("the reader lists only the first of {} images in '{}'", pyramids.size(), shown(group)));
  }
  const Json& datasets = member(pyramid, "datasets");
  if (!datasets.is_array() || datasets.empty()) throw ReadError("expected the levels of a pyramid, found none");
  if (level >= datasets.size()) {
    throw ReadError(fmt::format("expected a level from 0 to {}, found {}; the levels are {}", datasets.size() - 1,
                                level, level_list(hierarchy, group, datasets)));
  }
  const Json& dataset = datasets[level];
  Image image;
  image.name = group;
  image.array.path = join(group, checked_path(text_of(member(dataset, "path"))));
  image.array.metadata = hierarchy.array(image.array.path);
  const std::vector<std::uint64_t>& shape = image.array.metadata.shape;
  if (shape.size() < 2 || std::ranges::find(shape, 0U) != shape.end()) {
    throw ReadError("expected an array with samples along two or more axes");
  }
  image.axes = axes_of(pyramid, shape.size());
  image.scale.assign(shape.size(), 1);
  image.translation.assign(shape.size(), 0);
  apply_transformations(member(dataset, "coordinateTransformations"), image);
  apply_transformations(member(pyramid, "coordinateTransformations"), image);
  for (const Json& channel : member(member(ome, "omero"), "channels")) {
    image.channel_names.push_back(text_of(member(channel, "label")));
  }
  image.labels = labels_of(member(ome, "image-label"));

  std::string version = text_of(member(ome, "version"));
  if (version.empty()) version = text_of(member(pyramid, "version"));
  found.format = version.empty() ? "OME-Zarr" : fmt::format("OME-Zarr {}", shown(version));
  const Json& creator = member(node.attributes, "_creator");
  if (const std::string name = text_of(member(creator, "name")); !name.empty() && found.creator.empty()) {
    const std::string of = text_of(member(creator, "version"));
    found.creator = of.empty() ? name : name + ' ' + of;
  }
  return image;
}

}  // namespace isoextract_zarr

// Arrays outside of OME-Zarr images: takes axes from xarray's dimension names, and placement from coordinate arrays.
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "zarr_images.hpp"

namespace isoextract_zarr {
namespace {

constexpr std::uint64_t kMostCoordinates = std::uint64_t{1} << 20;

std::string group_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? std::string() : path.substr(0, slash);
}

std::vector<Axis> axes_of(const ArrayMetadata& array) {
  using enum Axis::Kind;
  std::vector<Axis> axes(array.shape.size());
  bool has_space = false;
  for (std::size_t i = 0; i < array.dimension_names.size(); ++i) {
    const std::string& name = array.dimension_names[i];
    const Axis::Kind kind = kind_called(name);
    axes[i].name = name;
    if (std::ranges::find(axes, kind, &Axis::kind) == axes.end()) axes[i].kind = kind;
    has_space = has_space || kind == x || kind == y || kind == z;
  }
  // Ignores names such as dim_0 if none is x, y or z.
  std::vector<Axis> unnamed = axes;
  for (Axis& axis : unnamed) {
    if (!has_space) axis.name.clear();
  }
  set_kinds_by_position(unnamed);
  for (std::size_t i = 0; i < axes.size(); ++i) axes[i].kind = unnamed[i].kind;
  return axes;
}

// Returns the values of a one-dimensional array; nothing if there is no array of `count` real numbers at `path`.
std::optional<std::vector<double>> coordinates_at(Hierarchy& hierarchy, const std::string& path, std::uint64_t count) {
  const auto node = hierarchy.find(path);
  if (!node || !node->is_array || count > kMostCoordinates) return std::nullopt;
  Array array{path, parse_array(*node)};
  const std::int32_t type = sample_type_of(array.metadata.type);
  if (array.metadata.shape != std::vector<std::uint64_t>{count} || type == ISOEXTRACT_NOT_SCALAR ||
      type == ISOEXTRACT_F16 || array.metadata.type.kind == DataType::Kind::complex) {
    return std::nullopt;
  }
  ArrayBox box;
  box.axes[0] = 0;
  box.count[0] = count;
  box.fixed = {0};
  return isoextract_plugin::with_sample_type(type, [&]<class T>(T) {
    std::vector<T> samples(count);
    static_cast<void>(read_box(hierarchy.store(), array, box, {}, samples.data(), hierarchy.host()));
    return std::optional(std::vector<double>(samples.begin(), samples.end()));
  });
}

// Tolerates rounding, because coordinates may be floats.
bool is_even(const std::vector<double>& values, double step) {
  const double size = std::max(std::abs(values.front()), std::abs(values.back()));
  constexpr double kOfStep = 1e-3;
  constexpr double kOfValue = 1e-6;
  const double tolerance = std::max(kOfStep * std::abs(step), std::min(kOfValue * size, 0.1 * std::abs(step)));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(std::abs(values[i] - (values.front() + static_cast<double>(i) * step)) <= tolerance)) return false;
  }
  return std::isfinite(step) && step != 0;
}

void place_axis(Hierarchy& hierarchy, std::size_t index, Image& image, Images& found) {
  Axis& axis = image.axes[index];
  if (axis.name.empty() || axis.name.find('/') != std::string::npos) return;
  const std::uint64_t count = image.array.metadata.shape[index];
  const std::string path = join(group_of(image.array.path), checked_path(axis.name));
  const auto values = coordinates_at(hierarchy, path, count);
  if (!values) return;
  const auto node = hierarchy.find(path);
  axis.unit = text_of(member(node->attributes, "units"));
  const bool is_space = axis.kind != Axis::Kind::time && axis.kind != Axis::Kind::channel;
  const double step = count > 1 ? (values->back() - values->front()) / static_cast<double>(count - 1) : 1;
  if (is_even(*values, step)) {
    image.scale[index] = step;
    image.translation[index] = values->front();
    image.has_placement = image.has_placement || is_space;
  } else if (axis.kind == Axis::Kind::time) {
    image.times = *values;
  } else if (is_space) {
    found.notes.push_back(fmt::format(
        "the coordinates of axis '{}' are not evenly spaced, so that they do not place it", shown(axis.name)));
  }
}

}  // namespace

Image describe_plain_array(Hierarchy& hierarchy, Array array, const Json& attributes, Images& found) {
  using enum Axis::Kind;
  Image image;
  image.name = array.path;
  image.array = std::move(array);
  image.axes = axes_of(image.array.metadata);
  image.scale.assign(image.axes.size(), 1);
  image.translation.assign(image.axes.size(), 0);
  const auto first_other = std::ranges::find_if(image.axes, [&](const Axis& axis) {
    return axis.kind == other && image.array.metadata.shape[static_cast<std::size_t>(&axis - image.axes.data())] > 1;
  });
  if (first_other != image.axes.end() && image.axis_of(time) == kNoAxis) {
    first_other->kind = time;
    found.notes.push_back(
        fmt::format("the volumes of '{}' lie along its axis '{}'", shown(image.name), shown(first_other->name)));
  }
  for (std::size_t i = 0; i < image.axes.size(); ++i) {
    try {
      place_axis(hierarchy, i, image, found);
    } catch (const ReadError& error) {
      found.notes.push_back(
          fmt::format("the coordinates of axis '{}' do not place it: {}", shown(image.axes[i].name), error.what()));
    }
  }
  // CF conventions, as xarray decodes them.
  const auto number = [&](const char* key, double otherwise) {
    const Json& value = member(attributes, key);
    return value.is_number() && std::isfinite(value.get<double>()) ? value.get<double>() : otherwise;
  };
  image.slope = number("scale_factor", 1);
  image.intercept = number("add_offset", 0);
  if (image.slope == 0) image.slope = 1;
  return image;
}

}  // namespace isoextract_zarr

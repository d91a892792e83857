// Finds the volumes of a hierarchy: OME-Zarr images and label images (NGFF 0.4 and 0.5, "multiscales"), and other
// arrays by the names of their dimensions.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "zarr_hierarchy.hpp"
#include "zarr_read.hpp"

namespace isoextract_zarr {

struct Axis {
  enum class Kind { x, y, z, time, channel, other };
  std::string name;
  Kind kind = Kind::other;
  std::string unit;
};

// One array, or one resolution of a pyramid.
struct Image {
  std::string name;  // path of the image's group or array
  Array array;
  std::vector<Axis> axes;           // one for each axis of the array
  std::vector<double> scale;        // of each axis: coordinate = scale * index + translation
  std::vector<double> translation;  // of the center of sample 0
  bool has_placement = false;
  std::vector<double> times;               // of an uneven time axis; empty if scale and translation are enough
  std::vector<std::string> channel_names;  // from its metadata; may be shorter than the axis
  std::vector<isoextract_plugin::Label> labels;
  double slope = 1;
  double intercept = 0;

  // Returns the axis of this kind, or kNoAxis.
  [[nodiscard]] int axis_of(Axis::Kind kind) const;
  // Returns the length of the axis of this kind, 1 if there is none.
  [[nodiscard]] std::uint64_t length_of(Axis::Kind kind) const;
};

struct Images {
  std::vector<Image> images;
  std::vector<std::string> notes;
  std::string format;   // "OME-Zarr 0.4", "Zarr v3"
  std::string creator;  // the program that wrote the first image
};

// Throws if there is no readable image, or for a level above 0 if there is no pyramid. Images without the level are
// left out, with a note; if none remains, the error lists the levels of the first image.
[[nodiscard]] Images find_images(Hierarchy& hierarchy, std::uint64_t level);

// Private to zarr_images.cpp, zarr_multiscales.cpp and zarr_plain_arrays.cpp.

// Reads one level of the pyramid of a group with `multiscales`. Throws if it has no such level, or is not valid.
[[nodiscard]] Image read_multiscales(Hierarchy& hierarchy, const std::string& group, const Node& node,
                                     std::uint64_t level, Images& found);
// Returns the members of OME-Zarr in a group's attributes: from version 0.5 on they are within "ome".
[[nodiscard]] const Json& ome_of(const Node& node);

// Describes an array: axes from its dimension names or number of axes, placement from xarray's coordinate arrays, slope
// and intercept from its attributes. Adds notes to `found`.
[[nodiscard]] Image describe_plain_array(Hierarchy& hierarchy, Array array, const Json& attributes, Images& found);
// Returns the kind of an axis with this name.
[[nodiscard]] Axis::Kind kind_called(const std::string& name);
// Gives axes without names the unused kinds, from the last axis on: x, y, z, then time and channel (four axes) or
// channel and time (other numbers).
void set_kinds_by_position(std::vector<Axis>& axes);

}  // namespace isoextract_zarr

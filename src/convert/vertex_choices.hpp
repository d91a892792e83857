// Requested attributes and colors of vertices, as plain values of a job.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/attribute_kind.hpp"
#include "base/error.hpp"
#include "edit/colormap.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::convert {

// A vertex attribute: its name and its source. For particles the source is one of their attributes; for volumes it is a
// grid of the same file, or another file (attribute_volumes.hpp).
struct AttributeChoice {
  static constexpr std::array kMembers{"name",    "from",   "written", "optional", "kind",
                                       "spacing", "origin", "no_data", "volume",   "component"};

  std::string name;
  std::string from;
  bool written = true;    // false: it only gives colors
  bool optional = false;  // true: an input without it is converted all the same
  // Nullopt: as the file says, else guessed from the name (attribute_kinds.hpp)
  std::optional<AttributeKind> kind = {};
  // For volumes: spacing and origin that replace those of the file, and a no-data value that replaces the input's.
  std::optional<glm::dvec3> spacing = {};
  std::optional<glm::dvec3> origin = {};
  std::optional<double> no_data = {};
  // For volumes: the volume to read from a file with several, and the component to read of samples with several.
  std::optional<std::int64_t> volume = {};
  std::optional<volume_io::ComponentChoice> component = {};

  [[nodiscard]] bool says_how_to_read() const { return spacing || origin || no_data || volume || component; }

  friend bool operator==(const AttributeChoice&, const AttributeChoice&) = default;
};

// An attribute that the input lacks, and the error to report if a vertex needs it.
struct MissingAttribute {
  AttributeChoice choice;
  Error error;
};

// Colors from a range of values by a colormap. For attributes with several components, their length is the value.
struct ColorChoice {
  static constexpr std::array kMembers{"attribute", "map", "range"};

  // One of the job's attributes; nullopt: each surface gets one color by its iso value.
  std::optional<std::string> attribute;
  edit::Colormap map = edit::Colormap::viridis;
  // Values at the colormap's ends, in rising order. nullopt: the range of the attribute's finite values at the
  // surface's vertices; without an attribute, the range of all iso values of the grid.
  std::optional<std::array<double, 2>> range;

  friend bool operator==(const ColorChoice&, const ColorChoice&) = default;
};

}  // namespace isoextract::convert

// What vertices shall carry besides their place, as plain values of a job.
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

// An attribute of the vertices: what they call it, and where it comes from. Of particles that is the name of one of
// theirs; of a volume a grid of the same file, or another file (attribute_source.hpp).
struct AttributeChoice {
  static constexpr std::array kMembers{"name",    "from",   "written", "optional", "kind",
                                       "spacing", "origin", "no_data", "volume",   "component"};

  std::string name;
  std::string from;
  bool written = true;                     // else it only gives colours
  bool optional = false;                   // an input that lacks it is converted without it
  std::optional<AttributeKind> kind = {};  // else as the file says, or by the name (attribute_kinds.hpp)
  // Of volumes: where the samples are, in place of what the file states, and the value that stands for no data, in
  // place of the input's.
  std::optional<glm::dvec3> spacing = {};
  std::optional<glm::dvec3> origin = {};
  std::optional<double> no_data = {};
  // Of volumes: which one of a file of several, and of several numbers a sample.
  std::optional<std::int64_t> volume = {};
  std::optional<volume_io::ComponentChoice> component = {};

  [[nodiscard]] bool says_how_to_read() const { return spacing || origin || no_data || volume || component; }

  friend bool operator==(const AttributeChoice&, const AttributeChoice&) = default;
};

// An attribute that the input lacks, and what is to be said where a vertex should have had it.
struct MissingAttribute {
  AttributeChoice choice;
  Error error;
};

// Colours, by a map from a range of values. Of several components their length counts.
struct ColourChoice {
  static constexpr std::array kMembers{"attribute", "map", "range"};

  std::optional<std::string>
      attribute;  // one of the job's attributes; nothing: each surface one colour by its iso value
  edit::Colormap map = edit::Colormap::viridis;
  // The values of the map's ends, the first below the second; nothing: the range over the vertices of the surface, or
  // that of the job's iso values.
  std::optional<std::array<double, 2>> range;

  friend bool operator==(const ColourChoice&, const ColourChoice&) = default;
};

}  // namespace isoextract::convert

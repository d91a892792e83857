// Values of the rooms below as JSON, the same in every document that the program writes.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "convert/json_type.hpp"
#include "field/scalar_field.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"

namespace isoextract::convert {

// null where there is none
template <class T>
[[nodiscard]] Json optional_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

[[nodiscard]] std::string_view kind_name(field::FieldKind kind);  // "density", "level set"

[[nodiscard]] Json json_of(const glm::dvec3& v);         // [x, y, z]
[[nodiscard]] Json json_of(const field::Box& box);       // {"min": [x, y, z], "max": [x, y, z]}
[[nodiscard]] Json json_of(const field::IndexBox& box);  // likewise; null if it is empty
[[nodiscard]] Json json_of(const field::Affine& map);    // three rows of four numbers: the matrix, then the offset
[[nodiscard]] Json json_of(const Error& error);          // kind, exit_code, reason (or null), message, hint
[[nodiscard]] Json json_of(const StageTime& time);       // wall_seconds, cpu_seconds
// What connectivity and size tell of a mesh; genus and volume are null unless it is closed.
[[nodiscard]] Json json_of(const mesh::Topology& topology, const mesh::MeshSize& size);

// A document as text. Names of files and grids may be in any encoding, JSON is UTF-8: every other byte becomes U+FFFD.
// Numbers that are not finite become null. A terminal that shows the text obeys nothing in it (printable_json()).
[[nodiscard]] std::string json_text(const Json& document);
// The same as one line without its end.
[[nodiscard]] std::string json_line(const Json& document);

}  // namespace isoextract::convert

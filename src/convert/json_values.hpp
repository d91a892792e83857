// Converts values of other rooms (folders of src) to JSON that is the same in every document of the program.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/note.hpp"
#include "base/stopwatch.hpp"
#include "convert/json_type.hpp"
#include "field/scalar_field.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"

namespace isoextract::convert {

// Returns null for nullopt.
template <class T>
[[nodiscard]] Json optional_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

[[nodiscard]] std::string_view kind_name(field::FieldKind kind);  // "density", "level set"

[[nodiscard]] Json json_of(const glm::dvec3& v);         // [x, y, z]
[[nodiscard]] Json json_of(const field::Box& box);       // {"min": [x, y, z], "max": [x, y, z]}
[[nodiscard]] Json json_of(const field::IndexBox& box);  // minimum and maximum; null if the box is empty
[[nodiscard]] Json json_of(const field::Affine& map);    // three rows of four numbers: linear part, then offset
// Returns kind, exit_code, reason (or null), message and `hint`, the error's hint as text.
[[nodiscard]] Json json_of(const Error& error, const std::string& hint);
[[nodiscard]] Json json_of_notes(const Notes& notes);  // [{"id": "open-mesh", "text": "..."}]
[[nodiscard]] Json json_of(const StageTime& time);     // wall_seconds, cpu_seconds
// Returns topology and size; genus and volume are null unless the mesh is a closed oriented manifold.
[[nodiscard]] Json json_of(const mesh::Topology& topology, const mesh::MeshSize& size);

// Returns the document as indented text that ends with a line end. JSON is UTF-8, but names of files and grids may not
// be: U+FFFD replaces each invalid sequence of bytes. Numbers that are not finite become null. The text is safe to
// print on a terminal (printable_json()).
[[nodiscard]] std::string json_text(const Json& document);
// Returns the document as json_text() does, but in one line without a line end.
[[nodiscard]] std::string json_line(const Json& document);

}  // namespace isoextract::convert

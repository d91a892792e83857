// Parses the JSON of a glTF file and reads values from it. Throws DamagedMesh for invalid values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include "base/finite.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {

// Parses untrusted text in linear time and with a limit on nesting. Returns null if it is not JSON.
[[nodiscard]] nlohmann::json parse_json(std::string_view text, MemoryUse& memory);

// Returns the beginning of the value's text, for messages.
[[nodiscard]] std::string shown(const nlohmann::json& value);

// Returns an unsigned integer member of the object. If there is none, returns `missing`, or throws if that is not set.
[[nodiscard]] std::uint64_t whole(const nlohmann::json& object, const char* key,
                                  std::optional<std::uint64_t> missing = {});

// Returns a string member of the object; empty if there is none.
[[nodiscard]] std::string_view text_of(const nlohmann::json& object, const char* key);

// Returns entry `index` of a top-level array of the model. The entry must be an object.
[[nodiscard]] const nlohmann::json& entry(const nlohmann::json& model, const char* list, std::uint64_t index);

// The affine transform of a node: p -> linear * p + offset.
struct Transform {
  glm::dmat3 linear{1.0};
  glm::dvec3 offset{0.0};

  [[nodiscard]] Transform after(const Transform& inner) const {
    return {linear * inner.linear, linear * inner.offset + offset};
  }
  [[nodiscard]] bool is_finite() const {
    return isoextract::is_finite(linear[0]) && isoextract::is_finite(linear[1]) && isoextract::is_finite(linear[2]) &&
           isoextract::is_finite(offset);
  }
};

[[nodiscard]] Transform transform_of(const nlohmann::json& node);

}  // namespace isoextract::mesh_io

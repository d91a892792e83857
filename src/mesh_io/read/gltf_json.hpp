// The JSON of a glTF file, and what its readers ask of it. Whatever is not as it should be is a DamagedMesh.
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

// In linear time, and of bounded depth. Null where it is no JSON.
[[nodiscard]] nlohmann::json parse_json(std::string_view text, MemoryUse& memory);

// The start of a value's text, for messages.
[[nodiscard]] std::string shown(const nlohmann::json& value);

// A whole number of an object, or `missing` where it has none.
[[nodiscard]] std::uint64_t whole(const nlohmann::json& object, const char* key,
                                  std::optional<std::uint64_t> missing = {});

// A text of an object; empty where it has none.
[[nodiscard]] std::string_view text_of(const nlohmann::json& object, const char* key);

// Entry `index` of a list of the model, an object.
[[nodiscard]] const nlohmann::json& entry(const nlohmann::json& model, const char* list, std::uint64_t index);

// Affine map of a node in double.
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

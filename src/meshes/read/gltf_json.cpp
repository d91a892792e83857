#include "meshes/read/gltf_json.hpp"

#include <array>

#include <fmt/format.h>

namespace isoextract::meshes {
namespace {

using nlohmann::json;

constexpr int kMaxDepth = 64;
// What a value of the JSON may take, with its key, its node in a map and the room of a growing list.
constexpr std::uint64_t kJsonValueBytes = 128;

template <std::size_t kCount>
std::array<double, kCount> numbers(const json& list, const char* key) {
  std::array<double, kCount> out{};
  const bool fits = list.is_array() && list.size() == kCount;
  for (std::size_t i = 0; fits && i < kCount; ++i) {
    if (!list[i].is_number()) throw DamagedMesh(fmt::format("expected numbers as '{}', found {}", key, shown(list)));
    out[i] = list[i].get<double>();
  }
  if (!fits) throw DamagedMesh(fmt::format("expected {} numbers as '{}', found {}", kCount, key, shown(list)));
  return out;
}

}  // namespace

// Values within values are visited by recursion, so hostile ones must not be deep.
json parse_json(std::string_view text, MemoryUse& memory) {
  memory.take(text.size());
  const auto check = [&](int depth, json::parse_event_t event, const json&) {
    if (event == json::parse_event_t::object_end || event == json::parse_event_t::array_end) return true;
    if (depth > kMaxDepth) {
      throw DamagedMesh(
          fmt::format("expected JSON nested at most {} deep, found a value at depth {}", kMaxDepth, depth));
    }
    memory.take(kJsonValueBytes);
    return true;
  };
  return json::parse(text, check, false);
}

std::string shown(const json& value) {
  return files::printable(value.dump(-1, ' ', true, json::error_handler_t::replace), 60);
}

std::uint64_t whole(const json& object, const char* key, std::optional<std::uint64_t> missing) {
  const auto found = object.find(key);
  if (found == object.end() && missing) return *missing;
  if (found == object.end()) throw DamagedMesh(fmt::format("expected '{}' in {}, found none", key, shown(object)));
  if (!found->is_number_unsigned()) {
    throw DamagedMesh(fmt::format("expected a whole number as '{}', found {}", key, shown(*found)));
  }
  return found->get<std::uint64_t>();
}

const json& entry(const json& model, const char* list, std::uint64_t index) {
  const auto found = model.find(list);
  const std::size_t size = found != model.end() && found->is_array() ? found->size() : 0;
  if (index >= size) {
    throw DamagedMesh(fmt::format("expected fewer than {} as an index into '{}', found {}", size, list, index));
  }
  if (!(*found)[index].is_object()) throw DamagedMesh(fmt::format("expected an object in '{}' at {}", list, index));
  return (*found)[index];
}

std::string_view text_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? std::string_view(found->get_ref<const std::string&>()) : "";
}

Transform transform_of(const json& node) {
  Transform transform;
  if (const auto matrix = node.find("matrix"); matrix != node.end()) {
    const auto m = numbers<16>(*matrix, "matrix");
    transform.linear = {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
    transform.offset = {m[12], m[13], m[14]};
    return transform;
  }
  if (const auto rotation = node.find("rotation"); rotation != node.end()) {
    const auto [x, y, z, w] = numbers<4>(*rotation, "rotation");
    // The rotation of a unit quaternion; glTF 2.0, 3.6.4.1.
    transform.linear = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w),     2 * (x * z - y * w),
                        2 * (x * y - z * w),     1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
                        2 * (x * z + y * w),     2 * (y * z - x * w),     1 - 2 * (x * x + y * y)};
  }
  if (const auto scale = node.find("scale"); scale != node.end()) {
    const auto factors = numbers<3>(*scale, "scale");
    for (int axis = 0; axis < 3; ++axis) transform.linear[axis] *= factors[static_cast<std::size_t>(axis)];
  }
  if (const auto translation = node.find("translation"); translation != node.end()) {
    const auto [x, y, z] = numbers<3>(*translation, "translation");
    transform.offset = {x, y, z};
  }
  return transform;
}

}  // namespace isoextract::meshes

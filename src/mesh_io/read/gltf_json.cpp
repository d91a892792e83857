#include "mesh_io/read/gltf_json.hpp"

#include <array>

#include <fmt/format.h>

namespace isoextract::mesh_io {
namespace {

using nlohmann::json;

constexpr int kMaxDepth = 64;
// Upper bound of the bytes that a JSON value needs, with its key, its map node and the spare capacity of a growing
// list.
constexpr std::uint64_t kJsonValueBytes = 128;

// Checks JSON before parsing builds a tree: limits nesting, since nested values are visited by recursion, and reserves
// memory. A callback of the library's parser could do the same, but then the library searches the enclosing list after
// every object.
class JsonLimits final : public nlohmann::json_sax<json> {
 public:
  explicit JsonLimits(MemoryUse& memory) : memory_(memory) {}

  bool null() override { return take(); }
  bool boolean(bool /*value*/) override { return take(); }
  bool number_integer(number_integer_t /*value*/) override { return take(); }
  bool number_unsigned(number_unsigned_t /*value*/) override { return take(); }
  bool number_float(number_float_t /*value*/, const string_t& /*text*/) override { return take(); }
  bool string(string_t& /*value*/) override { return take(); }
  bool binary(binary_t& /*value*/) override { return take(); }
  bool key(string_t& /*name*/) override { return take(); }
  bool start_object(std::size_t /*size*/) override { return begin(); }
  bool start_array(std::size_t /*size*/) override { return begin(); }
  bool end_object() override { return end(); }
  bool end_array() override { return end(); }
  bool parse_error(std::size_t /*place*/, const std::string& /*word*/,
                   const nlohmann::detail::exception& /*error*/) override {
    return false;
  }

 private:
  bool take() {
    if (depth_ > kMaxDepth) {
      throw DamagedMesh(
          fmt::format("expected JSON nested at most {} deep, found a value at depth {}", kMaxDepth, depth_));
    }
    memory_.take(kJsonValueBytes);
    return true;
  }
  bool begin() {
    take();
    ++depth_;
    return true;
  }
  bool end() {
    --depth_;
    return true;
  }

  MemoryUse& memory_;
  int depth_ = 0;
};

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

json parse_json(std::string_view text, MemoryUse& memory) {
  memory.take(text.size());
  JsonLimits limits(memory);
  if (!json::sax_parse(text, &limits)) return {};
  return json::parse(text, nullptr, false);
}

std::string shown(const json& value) {
  return files::printable(value.dump(-1, ' ', true, json::error_handler_t::replace), 60);
}

std::uint64_t whole(const json& object, const char* key, std::optional<std::uint64_t> missing) {
  const auto found = object.find(key);
  if (found == object.end() && missing) return *missing;
  if (found == object.end()) throw DamagedMesh(fmt::format("expected '{}' in {}, found none", key, shown(object)));
  if (!found->is_number_unsigned()) {
    throw DamagedMesh(fmt::format("expected a whole number as the value of '{}', found {}", key, shown(*found)));
  }
  return found->get<std::uint64_t>();
}

const json& entry(const json& model, const char* list, std::uint64_t index) {
  const auto found = model.find(list);
  const std::size_t size = found != model.end() && found->is_array() ? found->size() : 0;
  if (index >= size) {
    throw DamagedMesh(fmt::format("expected an index of one of the {} entries of '{}', found {}", size, list, index));
  }
  if (const json& value = (*found)[index]; !value.is_object()) {
    throw DamagedMesh(fmt::format("expected a JSON object as entry {} of '{}', found {}", index, list, shown(value)));
  }
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
    // The rotation matrix of a unit quaternion (glTF 2.0, 3.6.4.1).
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

}  // namespace isoextract::mesh_io

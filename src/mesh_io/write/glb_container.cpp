#include "mesh_io/write/glb_container.hpp"

#include <initializer_list>

namespace isoextract::mesh_io {
namespace {

std::string words_as_bytes(std::initializer_list<std::uint64_t> words) {
  std::string bytes;
  for (const std::uint64_t wide : words) {
    const auto word = static_cast<std::uint32_t>(wide);
    bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
  }
  return bytes;
}

}  // namespace

std::string glb_start(std::uint64_t json_bytes, std::uint64_t binary_bytes) {
  constexpr std::uint32_t kMagic = 0x46546C67;  // "glTF"
  constexpr std::uint32_t kContainerVersion = 2;
  constexpr std::uint32_t kJson = 0x4E4F534A;  // "JSON"
  return words_as_bytes({kMagic, kContainerVersion, glb_bytes(json_bytes, binary_bytes), json_bytes, kJson});
}

std::string glb_binary_head(std::uint64_t binary_bytes) {
  constexpr std::uint32_t kBinary = 0x004E4942;  // "BIN"
  return words_as_bytes({binary_bytes, kBinary});
}

void pad_glb_json(std::string& json) { json.resize(gltf_aligned(json.size()), ' '); }

}  // namespace isoextract::mesh_io

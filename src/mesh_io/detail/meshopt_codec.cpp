#include "mesh_io/detail/meshopt_codec.hpp"

#include <meshoptimizer.h>

namespace isoextract::mesh_io {
namespace {

const unsigned char* in(std::span<const std::byte> bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}
unsigned char* out_of(std::vector<std::byte>& bytes) { return reinterpret_cast<unsigned char*>(bytes.data()); }

// Sets the bit stream versions of the extension. They are global settings of the library, so they are set once.
void choose_versions() {
  [[maybe_unused]] static const bool chosen = [] {
    meshopt_encodeVertexVersion(0);
    meshopt_encodeIndexVersion(1);
    return true;
  }();
}

}  // namespace

std::string_view meshopt_word(MeshoptMode mode) {
  switch (mode) {
    case MeshoptMode::attributes: return "ATTRIBUTES";
    case MeshoptMode::triangles: return "TRIANGLES";
    case MeshoptMode::indices: return "INDICES";
  }
  return {};
}

std::vector<std::byte> encode_meshopt_values(std::span<const std::byte> values, std::size_t stride) {
  choose_versions();
  const std::size_t count = values.size() / stride;
  std::vector<std::byte> bytes(meshopt_encodeVertexBufferBound(count, stride));
  bytes.resize(meshopt_encodeVertexBuffer(out_of(bytes), bytes.size(), values.data(), count, stride));
  bytes.shrink_to_fit();
  return bytes;
}

std::vector<std::byte> encode_meshopt_triangles(std::span<const std::uint32_t> indices, std::size_t vertices) {
  choose_versions();
  std::vector<std::byte> bytes(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  bytes.resize(meshopt_encodeIndexBuffer(out_of(bytes), bytes.size(), indices.data(), indices.size()));
  bytes.shrink_to_fit();  // the bound is many times as large
  return bytes;
}

bool is_valid(const MeshoptView& view) {
  constexpr std::uint64_t kMaxStride = 256;
  if (view.mode != MeshoptMode::attributes) {
    const bool whole = view.mode == MeshoptMode::indices || view.count % 3 == 0;
    return whole && (view.stride == 2 || view.stride == 4) && view.filter == MeshoptFilter::none;
  }
  if (view.stride == 0 || view.stride > kMaxStride || view.stride % 4 != 0) return false;
  if (view.filter == MeshoptFilter::octahedral) return view.stride == 4 || view.stride == 8;
  return view.filter != MeshoptFilter::quaternion || view.stride == 8;
}

bool decode_meshopt(std::span<const std::byte> bytes, const MeshoptView& view, std::span<std::byte> out) {
  switch (view.mode) {
    case MeshoptMode::triangles:
      return meshopt_decodeIndexBuffer(out.data(), view.count, view.stride, in(bytes), bytes.size()) == 0;
    case MeshoptMode::indices:
      return meshopt_decodeIndexSequence(out.data(), view.count, view.stride, in(bytes), bytes.size()) == 0;
    case MeshoptMode::attributes: break;
  }
  if (meshopt_decodeVertexBuffer(out.data(), view.count, view.stride, in(bytes), bytes.size()) != 0) return false;
  switch (view.filter) {
    case MeshoptFilter::none: break;
    case MeshoptFilter::octahedral: meshopt_decodeFilterOct(out.data(), view.count, view.stride); break;
    case MeshoptFilter::quaternion: meshopt_decodeFilterQuat(out.data(), view.count, view.stride); break;
    case MeshoptFilter::exponential: meshopt_decodeFilterExp(out.data(), view.count, view.stride); break;
  }
  return true;
}

}  // namespace isoextract::mesh_io

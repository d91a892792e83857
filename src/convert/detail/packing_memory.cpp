#include "convert/detail/packing_memory.hpp"

#include <algorithm>
#include <array>

namespace isoextract::convert {
namespace {

// Bytes for each vertex.
struct Fit {
  std::uint64_t base;  // of work, for all vertices together
  PackingBytes none;
  PackingBytes smooth;
  PackingBytes flat;  // three corners for each triangle have values of their own
};

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20U;
constexpr Fit kDraco{6 * kMiB, {180, 5}, {300, 8}, {590, 12}};
constexpr Fit kMeshopt{3 * kMiB, {20, 16}, {72, 23}, {200, 60}};
constexpr Fit kQuantizedMeshopt{3 * kMiB, {30, 8}, {60, 13}, {100, 24}};
constexpr Fit kQuantized{3 * kMiB, {25, 32}, {60, 36}, {60, 72}};

}  // namespace

PackingBytes packing_bytes(const ConversionJob& job, std::uint64_t vertices) {
  const MeshFileOptions meshes = job.meshes();
  const bool quantize = meshes.packing.quantize;
  const Fit* fit = quantize ? &kQuantized : nullptr;
  if (meshes.packing.compression == mesh_io::Compression::meshopt) fit = quantize ? &kQuantizedMeshopt : &kMeshopt;
  if (meshes.packing.compression == mesh_io::Compression::draco || meshes.format == mesh_io::MeshFormat::drc)
    fit = &kDraco;
  if (fit == nullptr) return {};
  const PackingBytes& of_vertex = job.normals == Normals::none   ? fit->none
                                  : job.normals == Normals::flat ? fit->flat
                                                                 : fit->smooth;
  return {fit->base + vertices * of_vertex.work, vertices * of_vertex.packed};
}

void WaitingMeshes::add(std::uint64_t bytes, const PackingBytes& packing) {
  is_written_ |= most_ == 0 || (!meshes_.empty() && bytes_ + bytes > most_);
  if (is_written_) {
    meshes_.clear();
    bytes_ = 0;
    return;
  }
  meshes_.push_back({bytes, packing});
  bytes_ += bytes;
}

std::uint64_t WaitingMeshes::packing_peak() const {
  std::uint64_t most = 0;
  std::uint64_t held = bytes_;
  for (const Waiting& mesh : meshes_) {
    if (mesh.packing.work > 0) most = std::max(most, held + mesh.packing.work);
    held += mesh.packing.packed;
    held -= mesh.bytes;
  }
  return most;
}

}  // namespace isoextract::convert

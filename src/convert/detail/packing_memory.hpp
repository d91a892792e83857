// Estimates the memory of meshes that wait for the others of their file, and of packing meshes.
#pragma once

#include <cstdint>
#include <vector>

#include "convert/conversion_job.hpp"

namespace isoextract::convert {

// The memory of packing a mesh.
struct PackingBytes {
  std::uint64_t work = 0;    // at its peak, besides the mesh, with the packed form
  std::uint64_t packed = 0;  // of the packed form
};

// Returns zeros if the job packs no meshes. Expects two triangles for each vertex. Fits measured peaks of gyroids of
// 178,000 to 1.9 million vertices; the reservations cover the worst case, about twice as much.
[[nodiscard]] PackingBytes packing_bytes(const ConversionJob& job, std::uint64_t vertices);

// The meshes of a file, as they are before edits, while they wait for the others (mesh_io::MeshWriter).
class WaitingMeshes {
 public:
  // `most`: mesh_io::most_held_bytes().
  explicit WaitingMeshes(std::uint64_t most) : most_(most) {}

  // Adds a mesh of so many bytes.
  void add(std::uint64_t bytes, const PackingBytes& packing);
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  // Returns whether the writer packs each mesh when it comes.
  [[nodiscard]] bool packs_at_once() const { return most_ == 0; }
  // Returns the most memory while the meshes that wait are packed one after the other: those before in their packed
  // form, and those after as they are. Returns 0 if they are not packed.
  [[nodiscard]] std::uint64_t packing_peak() const;

 private:
  struct Waiting {
    std::uint64_t bytes = 0;
    PackingBytes packing;
  };

  std::uint64_t most_;
  std::uint64_t bytes_ = 0;
  std::vector<Waiting> meshes_;
  bool is_written_ = false;  // no mesh waits from now on
};

}  // namespace isoextract::convert

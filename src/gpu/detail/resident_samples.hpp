// Samples that stay on the device from one extraction to the next: Shustikov's window (toroidal_window.hpp) applied to
// time steps. Samples in the window are not copied again when the window moves, unless the field has changed there. A
// hash of each brick's content at its upload tells whether it has changed.
#pragma once

#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "field/samples.hpp"
#include "gl/gl_context.hpp"
#include "gl/gl_object.hpp"

namespace isoextract::gpu {

constexpr int kBrickSamples = 8;  // along each axis

// XXH3, 128 bits; zero if unknown.
struct BrickHash {
  std::uint64_t low = 0;
  std::uint64_t high = 0;

  friend bool operator==(const BrickHash&, const BrickHash&) = default;
};

// Returns the hash of the samples in `part` (a brick or the part of it in the field) and of its position. Different
// contents have the same hash only by chance.
[[nodiscard]] BrickHash brick_hash(const field::DenseSamples& samples, const field::IndexBox& part);

// The positions of bricks: brick (i, j, k) begins at sample origin + 8 (i, j, k); i, j and k are not negative.
struct BrickLattice {
  field::SampleType type = field::SampleType::f32;
  glm::ivec3 origin{0};

  friend bool operator==(const BrickLattice&, const BrickLattice&) = default;
};

// Limits for samples on the device.
struct TextureLimits {
  std::uint64_t bytes = 0;
  int size = 0;  // along each axis
};

// A texture with room for one brick at each address, and the hashes of the bricks in it. Belongs to a GL context.
class ResidentSamples {
 public:
  // Makes room for a box of bricks at once. Keeps the content if the lattice is unchanged and the texture is large
  // enough; else drops it. Returns false if the box exceeds `limits` or `host` has no memory for the hashes. Reserves
  // the memory of the hashes in `host` until drop(). Fails as GlContext::check() does.
  [[nodiscard]] Result<bool> make_room(const gl::GlContext& context, const BrickLattice& lattice,
                                       const field::IndexBox& bricks, const TextureLimits& limits, const Context& host);
  // Drops the texture and the hashes.
  void drop();

  [[nodiscard]] const gl::GlTexture& texture() const { return texture_; }
  // Returns the size in samples. Sample p is at texel (p - lattice origin) % size().
  [[nodiscard]] glm::ivec3 size() const { return kBrickSamples * bricks_per_axis_; }
  // Returns the index of a brick in the hashes.
  [[nodiscard]] std::size_t hash_index(const glm::ivec3& brick) const;

  // Take the hashes before an upload and give the new ones back after it. If the upload fails in between, the hashes
  // are lost and all bricks count as unknown.
  [[nodiscard]] std::vector<BrickHash> take_hashes();
  void give_back(std::vector<BrickHash> hashes) { hashes_ = std::move(hashes); }

 private:
  BrickLattice lattice_;
  glm::ivec3 bricks_per_axis_{0};
  gl::GlTexture texture_;
  std::vector<BrickHash> hashes_;  // by hash_index(); empty if nothing is known
  Reservation memory_;             // for the hashes
};

}  // namespace isoextract::gpu

// Samples that stay on the device from one extraction to the next: Shustikov's window (toroidal_window.hpp) over steps
// in time. What stays in the window is not copied again, wherever the window moves, unless the field has other samples
// there by now: what each brick held when it was uploaded is known by a hash.
#pragma once

#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "field/samples.hpp"
#include "gl/gl_context.hpp"
#include "gl/gl_object.hpp"

namespace isoextract::gpu {

constexpr int kBrickSamples = 8;  // along each axis

// XXH3, 128 bits; zero where nothing is known.
struct BrickHash {
  std::uint64_t low = 0;
  std::uint64_t high = 0;

  friend bool operator==(const BrickHash&, const BrickHash&) = default;
};

// Of the samples in a brick, or in the part of it that is there, and of where they are. Equal for others by chance
// only.
[[nodiscard]] BrickHash brick_hash(const field::DenseSamples& samples, const field::IndexBox& part);

// Where bricks are: brick (i, j, k) begins at sample origin + 8 (i, j, k), and no number is negative.
struct BrickLattice {
  field::SampleType type = field::SampleType::f32;
  glm::ivec3 origin{0};

  friend bool operator==(const BrickLattice&, const BrickLattice&) = default;
};

// What samples may take on the device.
struct TextureLimits {
  std::uint64_t bytes = 0;
  int size = 0;  // along each axis
};

// A texture with a place for one brick at each address, and what is in them. Belongs to a GL context.
class ResidentSamples {
 public:
  // Makes room for a box of bricks, all at a time. What is there stays where the lattice is the same and it is large
  // enough. False, and nothing is on the device, where the room is not there; the hashes are reserved in `host` for as
  // long as they live. Fails as GlContext::check() does.
  [[nodiscard]] Result<bool> make_room(const gl::GlContext& context, const BrickLattice& lattice,
                                       const field::IndexBox& bricks, const TextureLimits& limits, const Context& host);
  // Nothing is on the device any more, nor known of it.
  void drop();

  [[nodiscard]] const gl::GlTexture& texture() const { return texture_; }
  // In samples. Sample p is at texel (p - lattice origin) % size().
  [[nodiscard]] glm::ivec3 size() const { return kBrickSamples * places_; }
  // The place of a brick among the hashes.
  [[nodiscard]] std::size_t place(const glm::ivec3& brick) const;

  // Who uploads takes them, and gives them back as they are by then once the samples are there: where that fails on the
  // way, nothing is known.
  [[nodiscard]] std::vector<BrickHash> take_hashes();
  void give_back(std::vector<BrickHash> hashes) { hashes_ = std::move(hashes); }

 private:
  BrickLattice lattice_;
  glm::ivec3 places_{0};
  gl::GlTexture texture_;
  std::vector<BrickHash> hashes_;  // by place; none where nothing is known
  Reservation memory_;             // for them
};

}  // namespace isoextract::gpu

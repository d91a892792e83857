// Particles as a simulation leaves them: places, and named values of each.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/attribute_kind.hpp"
#include "base/buffer.hpp"
#include "base/memory_budget.hpp"

namespace isoextract::points {

// Values as float32, which is what meshes carry; integers beyond 2^24 and doubles are rounded to it.
struct ParticleAttribute {
  std::string name;                        // as the file has it
  std::size_t components = 1;              // values of one particle lie together
  Buffer<float> values;                    // components * particles
  std::optional<AttributeKind> kind = {};  // where the file says so
};

// Structure of arrays, in the order of the file.
struct ParticleSet {
  std::string label;  // what messages call it: the file, and the frame or part of it
  Buffer<glm::dvec3> positions;
  std::vector<ParticleAttribute> attributes;  // no two of one name
  Reservation memory;                         // for all of this, by whoever allocated it

  [[nodiscard]] std::size_t size() const { return positions.size(); }
};

}  // namespace isoextract::points

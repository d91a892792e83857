// Particles of a simulation: positions and named attributes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/attribute_kind.hpp"
#include "base/buffer.hpp"
#include "base/memory_budget.hpp"
#include "points/simulation_box.hpp"

namespace isoextract::points {

// Values are float32, as in meshes: doubles are rounded, and so are integers above 2^24.
struct ParticleAttribute {
  std::string name;                        // as in the file
  std::size_t components = 1;              // the values of one particle are consecutive
  Buffer<float> values;                    // components * particles
  std::optional<AttributeKind> kind = {};  // if the file specifies it
};

// One word per particle, such as the name of an element.
struct ParticleWords {
  std::string name;                // as in the file
  std::vector<std::string> words;  // distinct, in the order of their first particle
  Buffer<std::uint32_t> indices;   // into `words`, one for each particle
  bool too_many = false;           // more words than a reader keeps: `words` and `indices` are empty
};

// Structure of arrays in file order.
struct ParticleSet {
  std::string label;  // name for messages: the file, with the frame or part if any
  Buffer<glm::dvec3> positions;
  std::vector<ParticleAttribute> attributes;  // with unique names
  std::vector<ParticleWords> words = {};      // attributes whose values are words, such as chemical elements
  Reservation memory;                         // for all arrays; made by the code that allocated them
  std::optional<SimulationBox> box = {};      // valid (SimulationBox::is_valid()); particles can lie outside of it

  [[nodiscard]] std::size_t size() const { return positions.size(); }
};

}  // namespace isoextract::points

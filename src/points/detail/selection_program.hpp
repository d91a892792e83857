// A condition translated for one set of particles: operations on a stack of float64 values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "points/particle_set.hpp"
#include "points/selection_expression.hpp"

namespace isoextract::points {

// One operation; conditions are 1 or 0. SelectionOp::name puts a component of `attribute` on the stack; with `words`,
// whether the word is one of `matches`; with neither, a coordinate. SelectionOp::length puts the length of `attribute`
// there.
struct SelectionInstruction {
  SelectionOp op = SelectionOp::number;
  double number = 0;
  std::size_t component = 0;  // also of the position
  const ParticleAttribute* attribute = nullptr;
  const ParticleWords* words = nullptr;
  std::vector<std::uint8_t> matches = {};                 // by index of a word, 0 or 1
  std::vector<std::pair<double, double>> intervals = {};  // closed
};

struct SelectionProgram {
  std::vector<SelectionInstruction> instructions;
  std::size_t depth = 0;  // values that the stack needs
};

// Fails as choose_particles() does; the program refers to the particles.
[[nodiscard]] Result<SelectionProgram> program_of(const ParticleSet& particles, const SelectionExpression& condition);

}  // namespace isoextract::points

// Copies the parts of a field that a filter keeps.
#pragma once

#include "field/scalar_field.hpp"

namespace isoextract::field {

// Returns a copy without the samples, the notes and the names and ids of labels, which filtered samples no longer have.
inline ScalarField without_samples(const ScalarField& field) {
  ScalarField other;
  other.name = field.name;
  other.source = field.source;
  other.format = field.format;
  other.world_space = field.world_space;
  other.length_unit = field.length_unit;
  other.creator = field.creator;
  other.grids = field.grids;
  other.grid = field.grid;
  other.kind = field.kind;
  other.scale = field.scale;
  other.index_to_world = field.index_to_world;
  other.index_to_file = field.index_to_file;
  other.time = field.time;
  other.time_unit = field.time_unit;
  other.parts = field.parts;
  other.is_sampled = field.is_sampled;
  return other;
}

}  // namespace isoextract::field

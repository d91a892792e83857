// Facts about the work of a conversion: how many grids, bricks, samples, particles and the like it read, changed or
// left out, and why. --explain prints them and the report lists them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/enum_words.hpp"
#include "convert/attribute_volumes.hpp"
#include "convert/json_type.hpp"
#include "convert/particle_choice.hpp"
#include "extract/extractor.hpp"
#include "points/particle_field.hpp"

namespace isoextract::convert {

// Subjects that facts count. The JSON report has the words; docs/schemas/report.schema.json lists them.
enum class WorkTopic {
  grids,
  file_parts,
  resolution,
  labels,
  bricks,
  places,  // positions of bricks next to stored bricks
  samples,
  attributes,
  particles_not_chosen,
  particles_outside_region,
  particles,
  particles_not_finite,
  particles_too_small,
  particles_inside,
  filter,
  blur,
  nan_samples,
  hole_cells,
  uploads,
  resident,   // uploads left out, because the device still has the bricks
  decisions,  // ambiguous cells that the CPU decided for the GPU
  roi,
  normals,
  normal_copies,
  error,
  junction_vertices,  // vertices where a rectangle of voxel faces meets the side of another rectangle
  caps,
  whole_mesh,  // a mesh in memory, left out because each part of it goes to the file at once
};
constexpr auto words_of(WorkTopic /*type*/) {
  return std::array{Word{WorkTopic::grids, "grids"},
                    Word{WorkTopic::file_parts, "file_parts"},
                    Word{WorkTopic::resolution, "resolution"},
                    Word{WorkTopic::labels, "labels"},
                    Word{WorkTopic::bricks, "bricks"},
                    Word{WorkTopic::places, "places"},
                    Word{WorkTopic::samples, "samples"},
                    Word{WorkTopic::attributes, "attributes"},
                    Word{WorkTopic::particles_not_chosen, "particles_not_chosen"},
                    Word{WorkTopic::particles_outside_region, "particles_outside_region"},
                    Word{WorkTopic::particles, "particles"},
                    Word{WorkTopic::particles_not_finite, "particles_not_finite"},
                    Word{WorkTopic::particles_too_small, "particles_too_small"},
                    Word{WorkTopic::particles_inside, "particles_inside"},
                    Word{WorkTopic::filter, "filter"},
                    Word{WorkTopic::blur, "blur"},
                    Word{WorkTopic::nan_samples, "nan_samples"},
                    Word{WorkTopic::hole_cells, "hole_cells"},
                    Word{WorkTopic::uploads, "uploads"},
                    Word{WorkTopic::resident, "resident"},
                    Word{WorkTopic::decisions, "decisions"},
                    Word{WorkTopic::roi, "roi"},
                    Word{WorkTopic::normals, "normals"},
                    Word{WorkTopic::normal_copies, "normal_copies"},
                    Word{WorkTopic::error, "error"},
                    Word{WorkTopic::junction_vertices, "border_vertices"},
                    Word{WorkTopic::caps, "caps"},
                    Word{WorkTopic::whole_mesh, "whole_mesh"}};
}
enum class WorkDone {
  left_out,
  read,
  made_into_a_field,
  filtered,
  blurred,
  resampled,
  visited,
  compared,
  taken_as_outside,
  left_as_holes,
  uploaded,
  taken_by_the_processor,  // computed on the CPU
  mapped,
  copied,
  rounded,
};
constexpr auto words_of(WorkDone /*type*/) {
  return std::array{Word{WorkDone::left_out, "left out"},
                    Word{WorkDone::read, "read"},
                    Word{WorkDone::made_into_a_field, "made into a field"},
                    Word{WorkDone::filtered, "filtered"},
                    Word{WorkDone::blurred, "blurred"},
                    Word{WorkDone::resampled, "resampled"},
                    Word{WorkDone::visited, "visited"},
                    Word{WorkDone::compared, "compared"},
                    Word{WorkDone::taken_as_outside, "taken as outside"},
                    Word{WorkDone::left_as_holes, "left as holes"},
                    Word{WorkDone::uploaded, "uploaded"},
                    Word{WorkDone::taken_by_the_processor, "taken by the processor"},
                    Word{WorkDone::mapped, "mapped"},
                    Word{WorkDone::copied, "copied"},
                    Word{WorkDone::rounded, "rounded"}};
}

struct WorkFact {
  WorkTopic what = WorkTopic::bricks;
  WorkDone done = WorkDone::left_out;
  std::optional<std::uint64_t> count;  // of `what`; nullopt if it cannot be counted
  std::optional<std::uint64_t> total;  // of which `count` is a part
  std::string text;                    // rest of the printed sentence: "12 of 64 bricks (...), which ..."
};
[[nodiscard]] Json json_of(const WorkFact& fact);

// Returns facts about reading `field`; the conversion also reads `more_grids` other grids of the file.
[[nodiscard]] std::vector<WorkFact> reading_facts(const field::ScalarField& field, std::size_t more_grids);

// Returns a fact about an attribute that was read.
[[nodiscard]] WorkFact attribute_fact(const VolumeAttribute& attribute);

// Returns a fact about the particles that were not chosen.
[[nodiscard]] WorkFact choice_fact(const ParticleCount& count, const ParticleOptions& options);

// Returns a fact about the particles left out because they cannot affect the surface in the region. count.chosen is the
// number that remains.
[[nodiscard]] WorkFact region_fact(const ParticleCount& count);

// Returns facts about the field made from particles.
[[nodiscard]] std::vector<WorkFact> particle_facts(const points::ParticleFieldStatistics& figures);

// Returns a fact about resample(), which made `grid` from `data`.
[[nodiscard]] WorkFact resolution_fact(const field::ScalarField& data, const field::ScalarField& grid);

}  // namespace isoextract::convert

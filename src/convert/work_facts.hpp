// What a conversion looked at, took otherwise than it is stored, or left out, and why. --explain prints these facts and
// the report lists them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "convert/attribute_source.hpp"
#include "extract/extractor.hpp"
#include "points/particle_field.hpp"

namespace isoextract::convert {

struct WorkFact {
  std::string what;                    // "bricks", "grids", "normals", ...: for programs that read the report
  std::string done;                    // "left out", "resampled", "visited", "compared", "taken as outside", ...
  std::optional<std::uint64_t> count;  // how many, where that is a number
  std::optional<std::uint64_t> total;  // out of how many
  std::string text;                    // the rest of the sentence: "12 of 64 bricks (...), which ..."
};

// Of reading `field`.
[[nodiscard]] std::vector<WorkFact> reading_facts(const field::ScalarField& field);

// Of an attribute that was read.
[[nodiscard]] WorkFact attribute_fact(const VolumeAttribute& attribute);

// Of the field that particles made.
[[nodiscard]] std::vector<WorkFact> particle_facts(const points::FieldFigures& figures);

// Of resample(), which made `grid` of `data`.
[[nodiscard]] WorkFact resolution_fact(const field::ScalarField& data, const field::ScalarField& grid);

// What was asked for besides the extraction.
struct AskedFor {
  bool triangle_normals = false;  // made of the triangles when the mesh is written, or before
  bool error = false;
};

// Of one extraction.
[[nodiscard]] std::vector<WorkFact> extraction_facts(const extract::ExtractStats& stats,
                                                     const extract::ExtractOptions& options, const AskedFor& asked);

}  // namespace isoextract::convert

// What `info` found out about one input, and its two ways onto paper.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "convert/json_values.hpp"
#include "field/scalar_field.hpp"
#include "field/statistics.hpp"
#include "volumes/volume_reader.hpp"

namespace isoextract::cli {

// Of the one field that was read.
struct FieldReport {
  field::ScalarField field;
  field::FieldStatistics statistics;
  field::IsoSuggestion suggestion;
  std::uint64_t sample_bytes = 0;
  std::uint64_t vertices = 0;          // estimated, of the surface at the suggested iso value
  std::uint64_t conversion_bytes = 0;  // estimated peak of memory of that conversion
  std::string command;                 // line that makes it
};

struct InputReport {
  std::string input;
  std::vector<volumes::GridInfo> grids;
  std::optional<FieldReport> field;  // not there if a choice of grid or a place for it is missing, or on an error
  std::optional<Error> error;
};

// The program itself, the samples, two bits of marks for each, and the mesh with normals: within a tenth of what large
// conversions take.
[[nodiscard]] std::uint64_t estimated_conversion_bytes(std::uint64_t sample_bytes, std::uint64_t samples,
                                                       std::uint64_t vertices);
// A closed surface has about twice as many.
[[nodiscard]] std::uint64_t estimated_triangles(std::uint64_t vertices);

[[nodiscard]] std::string text_of(const InputReport& report);
[[nodiscard]] convert::Json json_of(const InputReport& report);

}  // namespace isoextract::cli

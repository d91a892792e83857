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

// What a conversion at the suggested iso value has to do with; estimated but for the samples.
struct ConversionSize {
  std::uint64_t samples = 0;  // that are stored
  std::uint64_t sample_bytes = 0;
  std::uint64_t lookup_bytes = 0;  // to find sparse blocks by their place
  std::uint64_t places = 0;        // of sparse samples that the surface passes
  std::uint64_t vertices = 0;
};

// Of the one field that was read.
struct FieldReport {
  field::ScalarField field;
  field::FieldStatistics statistics;
  field::IsoSuggestion suggestion;
  ConversionSize size;
  bool fits_one_mesh = true;  // else only parts of it can be extracted
  std::string command;        // line that extracts it, if there is one that does
};

struct InputReport {
  std::string input;
  std::vector<volumes::GridInfo> grids;
  std::optional<FieldReport> field;  // not there if a choice of grid or a place for it is missing, or on an error
  std::optional<Error> error;
};

// The peak of memory: the program itself, the samples, two bits of marks for each, what finds its way among sparse
// blocks, and the mesh with normals. Within a tenth of what large conversions take, for blocks far apart a fifth.
[[nodiscard]] std::uint64_t estimated_bytes(const ConversionSize& size);
// A closed surface has about twice as many as vertices.
[[nodiscard]] std::uint64_t estimated_triangles(const ConversionSize& size);

[[nodiscard]] std::string text_of(const InputReport& report);
[[nodiscard]] convert::Json json_of(const InputReport& report);

}  // namespace isoextract::cli

// What `info` found out about one input, and its two ways onto paper.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/particle_report.hpp"
#include "convert/conversion_size.hpp"
#include "convert/json_type.hpp"
#include "field/scalar_field.hpp"
#include "field/statistics.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::cli {

// Of the one field that was read.
struct FieldReport {
  field::ScalarField field;
  field::FieldStatistics statistics;
  field::IsoSuggestion suggestion;
  convert::ConversionSize size;
  std::uint64_t bytes = 0;    // of memory that converting takes
  bool fits_one_mesh = true;  // else only parts of it can be extracted
  std::string command;        // line that extracts it, if there is one that does
};

struct InputReport {
  std::string input;
  std::vector<volume_io::GridInfo> grids;
  std::optional<std::int64_t> volume;                   // that is described, where one was chosen or there are several
  std::optional<volume_io::ComponentChoice> component;  // likewise
  std::optional<ParticleReport> particles;              // where the input is of particles, which have no grids
  std::optional<FieldReport> field;  // not there if a choice of grid or a place for it is missing, or on an error
  std::optional<Error> error;
};

// The grid that read_volume takes where none is named; null where one has to be, or none can be read.
[[nodiscard]] const volume_io::GridInfo* grid_without_choice(std::span<const volume_io::GridInfo> grids);
[[nodiscard]] bool has_several_volumes(const volume_io::GridInfo& grid);
[[nodiscard]] bool has_several_components(const volume_io::GridInfo& grid);

[[nodiscard]] std::string text_of(const InputReport& report);
[[nodiscard]] convert::Json json_of(const InputReport& report);

}  // namespace isoextract::cli

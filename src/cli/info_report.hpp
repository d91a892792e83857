// The results of `info` for one input, as text and as JSON.
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

// The results for the field that was read.
struct FieldReport {
  field::ScalarField field;
  field::FieldStatistics statistics;
  field::IsoSuggestion suggestion;
  convert::ConversionSize size;
  std::uint64_t bytes = 0;    // memory that a conversion needs
  bool fits_one_mesh = true;  // otherwise only regions of the field fit one mesh
  std::string command;        // a command line that extracts it; may be empty
};

struct InputReport {
  std::string input;
  std::vector<volume_io::GridInfo> grids;
  std::optional<std::int64_t> volume;                   // this report's volume, if chosen or one of several
  std::optional<volume_io::ComponentChoice> component;  // this report's component, in the same cases
  std::optional<ParticleReport> particles;              // for particles, which have no grids
  std::optional<FieldReport> field;  // unset if the grid or its placement is not chosen, or on an error
  std::optional<Error> error;
};

// Returns the grid that read_volume() reads without a name; null if a name is necessary or no grid is readable.
[[nodiscard]] const volume_io::GridInfo* grid_without_choice(std::span<const volume_io::GridInfo> grids);
[[nodiscard]] bool has_several_volumes(const volume_io::GridInfo& grid);
[[nodiscard]] bool has_several_components(const volume_io::GridInfo& grid);

[[nodiscard]] std::string text_of(const InputReport& report);
[[nodiscard]] convert::Json json_of(const InputReport& report);

}  // namespace isoextract::cli

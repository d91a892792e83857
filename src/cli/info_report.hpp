// The results of `info` for one input, as text and as JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "cli/label_report.hpp"
#include "cli/particle_report.hpp"
#include "convert/conversion_size.hpp"
#include "convert/json_type.hpp"
#include "field/scalar_field.hpp"
#include "field/statistics.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::cli {

// The options that `info` suggests for label maps and masks, and for masks in separate files.
inline constexpr std::string_view kAllLabels = "--labels all";
inline constexpr std::string_view kAllMasks = "--masks --labels all";

// The results for the field that was read.
struct FieldReport {
  field::ScalarField field;
  field::FieldStatistics statistics;
  field::IsoSuggestion suggestion;    // not shown for a label map or mask
  std::optional<field::CtIsos> ct;    // of a CT scan, besides the suggestion
  std::optional<LabelReport> labels;  // of a label map or mask
  convert::ConversionSize size;
  std::uint64_t bytes = 0;             // estimated memory of a conversion
  std::uint64_t whole_mesh_bytes = 0;  // estimated with options that need the whole mesh
  bool is_slice = false;               // one slice of samples, which has no surface but can be terrain
  bool fits_one_mesh = true;           // otherwise only regions of the field fit one mesh
  std::string command;                 // an example command line; empty without a suggestion or if !fits_one_mesh
};

struct InputReport {
  std::string input;
  std::vector<volume_io::GridInfo> grids;
  std::optional<std::int64_t> volume;  // this report's volume or particle frame, if chosen or one of several
  std::optional<volume_io::ComponentChoice> component;  // this report's component, if chosen or one of several
  std::optional<ParticleReport> particles;              // for particles, which have no grids
  // Unset if no grid is chosen, if the grid's placement is unusable, if the particles give no field, or on an error.
  std::optional<FieldReport> field;
  std::optional<Error> error;
};

// Returns the grid that read_volume() chooses without a name; null if there is no grid or a name is necessary. The
// grid may be unreadable: a single scalar grid counts even if its placement is unusable.
[[nodiscard]] const volume_io::GridInfo* grid_without_choice(std::span<const volume_io::GridInfo> grids);
[[nodiscard]] bool has_several_volumes(const volume_io::GridInfo& grid);
[[nodiscard]] bool has_several_components(const volume_io::GridInfo& grid);

// Returns the report without its error.
[[nodiscard]] std::string text_of(const InputReport& report);
// Returns the report with its error, and without the key "schema".
[[nodiscard]] convert::Json json_of(const InputReport& report);

}  // namespace isoextract::cli

// Conversions of several grids of one input: which grid the surfaces of an output are of, and whether all are there.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::convert {

// All grids of a job, in its order; an empty value where none was chosen.
[[nodiscard]] std::vector<std::optional<std::string>> grids_of(const SourceOptions& source);
// Those whose surfaces are in `output`.
[[nodiscard]] std::vector<std::optional<std::string>> grids_of(const SourceOptions& source,
                                                               const OutputFileJob& output);

// The options that read one of these grids. SourceOptions::more_grids stays: it says how many others are read.
[[nodiscard]] SourceOptions with_grid(const SourceOptions& source, const std::optional<std::string>& grid);

// The iso values of a grid, of all outputs that have surfaces of it, and the index of the first one of an output.
[[nodiscard]] std::vector<IsoChoice> isos_of(const ConversionJob& job, const std::optional<std::string>& grid);
[[nodiscard]] std::size_t first_iso_of(const ConversionJob& job, std::size_t output,
                                       const std::optional<std::string>& grid);

// Of jobs with several grids: fails where one is not in the input or holds particles, and where two names stand for one
// grid. Reads no samples.
[[nodiscard]] Result<void> check_grids(const SourceOptions& source, const Context& context);

}  // namespace isoextract::convert

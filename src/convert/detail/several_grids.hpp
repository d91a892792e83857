// Jobs with several grids of one input: the grids of each output, and a check that all grids exist.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::convert {

// Returns all grids of a job, in order. nullopt stands for the only grid of a job that chose none.
[[nodiscard]] std::vector<std::optional<std::string>> grids_of(const SourceOptions& source);
// Returns the grids whose surfaces go into `output`.
[[nodiscard]] std::vector<std::optional<std::string>> grids_of(const SourceOptions& source,
                                                               const OutputFileJob& output);

// Returns options that read one of these grids. SourceOptions::more_grids stays: it says how many others are read.
[[nodiscard]] SourceOptions with_grid(const SourceOptions& source, const std::optional<std::string>& grid);

// Returns the iso values of a grid, over all outputs that contain its surfaces.
[[nodiscard]] std::vector<IsoChoice> isos_of(const ConversionJob& job, const std::optional<std::string>& grid);
// Returns the index in isos_of() of the first iso value of one output, which contains surfaces of the grid.
[[nodiscard]] std::size_t first_iso_of(const ConversionJob& job, std::size_t output,
                                       const std::optional<std::string>& grid);

// Checks jobs with several grids. Fails with ErrorCode::input if a grid is not in the input, and with ErrorCode::usage
// if a grid holds particles or two names mean the same grid. Reads no samples.
[[nodiscard]] Result<void> check_grids(const SourceOptions& source, const Context& context);

}  // namespace isoextract::convert

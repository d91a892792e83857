// Jobs with several grids of one input, or several layers of a label map: the grids of each output, the layers of each
// grid, and a check that all grids exist.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/iso_values.hpp"
#include "extract/voxels.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

// Returns all grids of a job, in order. nullopt stands for the only grid of a job that chose none.
[[nodiscard]] std::vector<std::optional<std::string>> grids_of(const SourceOptions& source);
// Returns the grids whose surfaces go into `output`.
[[nodiscard]] std::vector<std::optional<std::string>> grids_of(const SourceOptions& source,
                                                               const OutputFileJob& output);

// Returns options that read one of these grids. SourceOptions::more_grids stays, for the number of other grids read.
[[nodiscard]] SourceOptions with_grid(const SourceOptions& source, const std::optional<std::string>& grid);

// Returns the iso values of a grid, over all outputs that contain its surfaces.
[[nodiscard]] std::vector<IsoChoice> isos_of(const ConversionJob& job, const std::optional<std::string>& grid);
// Returns the index in isos_of() of the first iso value of `output`, which must contain surfaces of the grid.
[[nodiscard]] std::size_t first_iso_of(const ConversionJob& job, std::size_t output,
                                       const std::optional<std::string>& grid);

// Returns the volumes of a grid to extract from, in order. Usually this is SourceOptions::read.volume alone. If that is
// unset and all `isos` are labels, returns the layers of a label map with overlapping labels (field::LabelName::layer).
// Fails as volume_io::list_grids() does. Reads no samples.
[[nodiscard]] Result<std::vector<std::optional<std::int64_t>>> volumes_of(const SourceOptions& source,
                                                                          const std::vector<IsoChoice>& isos,
                                                                          const Context& context);

// Returns the labels to extract; nothing if there is an iso value among `isos`, or no label.
[[nodiscard]] std::optional<extract::LabelChoice> chosen_labels(std::span<const ResolvedIso> isos,
                                                                std::int64_t background);

// Returns the surfaces to extract from a field, each once: the iso values in `asked`, or the chosen `labels` if not
// null. If `asked` lists labels and the field is one of several layers, returns only the labels that the file names for
// this layer. The first layer also gets the labels that the file does not name.
[[nodiscard]] std::vector<ResolvedIso> surfaces_of(const field::ScalarField& field, std::span<const ResolvedIso> asked,
                                                   const std::vector<std::int64_t>* labels,
                                                   std::optional<std::int64_t> layer);

// Checks jobs with several grids. Fails with ErrorCode::input if a grid is not in the input, and with ErrorCode::usage
// if a grid holds particles or two names mean the same grid. Reads no samples.
[[nodiscard]] Result<void> check_grids(const SourceOptions& source, const Context& context);

}  // namespace isoextract::convert

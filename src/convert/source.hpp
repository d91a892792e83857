// The stage that reads: a field, on the grid that was asked for, and its place in the output.
#pragma once

#include <optional>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"

namespace isoextract::convert {

// read_volume(), with its notes told.
[[nodiscard]] Result<field::ScalarField> read_field(const std::string& input, const volumes::ReadOptions& options,
                                                    const Context& context, Events& events);

struct Source {
  field::ScalarField field;                // to extract from
  std::optional<field::ScalarField> data;  // what was read, where `field` is another grid and the data were asked for
  field::Affine output_from_index;
  std::optional<field::IndexBox> region;
  std::string label;   // what messages call it
  bool empty = false;  // what was read has no voxels

  // How a surface of it is extracted.
  [[nodiscard]] extract::ExtractOptions extract_options(const SurfaceOptions& surface, double iso) const;
};

// Source::data is there only with `keep_data`. Fails as read_volume(), resample() and place_field() do.
[[nodiscard]] Result<Source> open_source(const SourceOptions& options, bool keep_data, const Context& context,
                                         Events& events);

}  // namespace isoextract::convert

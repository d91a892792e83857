// Reads the grid whose values `isoextract render --emission` turns into light.
#pragma once

#include <optional>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "cli/options/render.hpp"
#include "convert/events.hpp"
#include "convert/source.hpp"
#include "render/transfer_function.hpp"

namespace isoextract::cli {

struct EmissionSource {
  field::ScalarField field;
  field::Affine output_from_index;
  render::TransferFunction light;
  double greatest = 0;  // the greatest finite value
};

// Fails with ErrorCode::usage if the input is particles. Opens the input.
[[nodiscard]] Result<void> check_emission_input(const EmissionChoice& choice, const convert::SourceOptions& options,
                                                const Context& context);

// Reads the grid from the input of `source`, which `options` describe, and places it like the source. Returns nothing
// if the grid has no voxels, and notes so; also notes a grid whose values emit no light.
// Fails with ErrorCode::input if the file has no such grid, or if the grid holds vectors or labels. Without a range it
// also fails if the values are too small for kelvins; the hint then names a range. Fails as read_field() does.
[[nodiscard]] Result<std::optional<EmissionSource>> read_emission(const EmissionChoice& choice,
                                                                  const convert::SourceOptions& options,
                                                                  const convert::Source& source, const Context& context,
                                                                  convert::Events& events);

}  // namespace isoextract::cli

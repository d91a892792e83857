// The stage that resamples a level set which is written as a file.
#pragma once

#include <optional>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "field/scalar_field.hpp"
#include "volume_io/volume_writer.hpp"

namespace isoextract::convert {

// Returns the level set `field` at the resolution that `options` ask for, and reports it. The result has a narrow band
// of three new voxels on either side; interpolation would keep the width of the old band. A requested voxel size is
// exact. Returns a copy of `field` if it has that resolution already.
//
// Returns nothing if the caller has to interpolate:
// - if the field's file does not state a narrow-band level set: a density, dense samples, or a kind that the user chose
// - if the options ask for fewer than two samples along an axis
// - with a note, if OpenVDB makes no such level set: the new voxels are not cubic, or the axes are not perpendicular
// - with a note, if the options require interpolation: another kernel than linear, or a resolution for a file of dense
//   samples
//
// Fails as volume_io::rebuild_level_set() does.
[[nodiscard]] Result<std::optional<field::ScalarField>> rebuild_level_set(const SourceOptions& options,
                                                                          volume_io::VolumeFileFormat format,
                                                                          const field::ScalarField& field,
                                                                          const Context& context, Events& events);

}  // namespace isoextract::convert

// Values that the frames of a sequence share, found in the inputs before the first conversion.
#pragma once

#include <cstdint>
#include <optional>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "edit/vertex_colors.hpp"

namespace isoextract::convert {

struct FoundRadius {
  std::optional<double> radius;  // points::suggest_radius() of the particles
  std::uint64_t particles = 0;   // of the input, chosen and inside the region
  bool has_attribute = false;    // the particles have a radius attribute, which counts instead
};

// Reads the particles of the input and suggests a radius. Fails as particle_io::read_particles() and
// points::suggest_radius() do.
[[nodiscard]] Result<FoundRadius> find_radius(const SourceOptions& options, const Context& context);

// Reads the particles of the input and returns the spacing that choose_sphere_spacing() chooses. Fails as
// particle_io::read_particles() and choose_sphere_spacing() do.
[[nodiscard]] Result<std::optional<double>> find_sphere_spacing(const SourceOptions& options, const Context& context);

// Reads the attribute that gives the colors (ColorChoice::attribute), and returns the range of its finite values; for
// several components, the range of their length. Takes the values of all chosen particles, of all vertices of a mesh
// file, or of all samples except the background of sparse grids. Components with different sparse blocks give a range
// from 0 to a bound of the length. Returns nothing if the input lacks the attribute, or if no value is finite. Reads
// the input as a conversion does, and fails as its reader does.
[[nodiscard]] Result<std::optional<edit::ValueRange>> find_color_range(const ConversionJob& job,
                                                                       const Context& context);

}  // namespace isoextract::convert

// Work on grids with OpenVDB, which a plug-in does (plugins/grid_tools_plugin.h) that is opened when it is asked for:
// particles to surfaces of spheres, filters of level sets, and fields as VDB files.
//
// All of them fail with ErrorCode::unavailable where the plug-in is missing or does not fit, with ErrorCode::usage for
// options outside of what they say, and with ErrorCode::input for fields and particles that they cannot work on. Memory
// is reserved in the context, in which the work can be cancelled.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/words.hpp"
#include "field/scalar_field.hpp"
#include "points/method.hpp"
#include "points/particle_set.hpp"

namespace isoextract::volume_io {

enum class SphereMethod {
  spheres,  // the union of the particles' spheres
  // The sphere around the weighted mean of the particles nearby: Y. Zhu and R. Bridson, "Animating sand as a fluid",
  // SIGGRAPH 2005, section 5.
  smooth,
};

struct SphereOptions {
  SphereMethod method = SphereMethod::spheres;
  field::FieldKind kind = field::FieldKind::level_set;
  double radius = 0;             // of every particle, in the world, where `radii` is empty
  std::span<const float> radii;  // of each
  double search_radius = 0;      // of the smooth method: how far a particle reaches, in the world
  double voxel = 0;              // spacing of the field's samples, one of which is at the world's origin
  double half_band = 3;          // voxels on either side of the surface whose distance is kept; 2 to 1000
  // In voxels: smaller spheres fall between samples, and are left out with a note.
  double least_radius = points::kLeastSphere;
};

struct SphereField {
  field::ScalarField field;
  std::uint64_t left_out = 0;  // particles
};

// Whether there is a plug-in, before the work is prepared; `work` starts the message where it is missing.
[[nodiscard]] Result<void> check_grid_tools(const std::string& work);

// The signed distance from the spheres in the world's unit, negative inside and constant beyond the band; its surface
// is at iso value 0. As a density 1 inside and 0 outside, with a ramp of half_band voxels inside of that surface.
// Sparse, in f32, the same for any number of threads.
[[nodiscard]] Result<SphereField> spheres_to_field(const points::ParticleSet& particles, const SphereOptions& options,
                                                   const Context& context);

enum class LevelSetFilter { gaussian, median, mean };
constexpr auto words_of(LevelSetFilter /*type*/) {
  return std::array{Word{LevelSetFilter::gaussian, "gaussian"}, Word{LevelSetFilter::median, "median"},
                    Word{LevelSetFilter::mean, "mean"}};
}
inline constexpr int kMaxFilterWidth = 64;

// Filters the values of a level set of cubic voxels around its surface, `iterations` times, each with those up to
// `width` voxels away (1 to 64), and mends the distances. The field is read as f32, and comes out so, sparse.
[[nodiscard]] Result<field::ScalarField> filter_level_set(const field::ScalarField& field, LevelSetFilter filter,
                                                          int width, int iterations, const Context& context);

struct VdbWriteOptions {
  std::string name;      // of the grid; empty: the field's
  bool as_half = false;  // values are rounded to 16 bits
};

// Writes a file of grids of floats, one or more, whole or not at all; samples of other types are rounded to that. A
// level set has the class "level set", a density "fog volume". Which voxels are active and what is beyond a dense field
// says grid_tools_plugin.h. To standard output or a pipe it is written as a stream. Gives the number of bytes. Fails
// with ErrorCode::output as well.
[[nodiscard]] Result<std::uint64_t> write_vdb(const std::filesystem::path& path, const field::ScalarField& field,
                                              const VdbWriteOptions& options, const Context& context);
// Each grid has its field's name.
[[nodiscard]] Result<std::uint64_t> write_vdb(const std::filesystem::path& path,
                                              std::span<const field::ScalarField> fields, const Context& context);

}  // namespace isoextract::volume_io

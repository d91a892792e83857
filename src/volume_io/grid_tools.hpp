// Grid operations by OpenVDB, in a plug-in that is opened on demand (plugins/grid_tools_plugin.h): level sets of
// spheres, filtered and rebuilt level sets, and VDB output.
//
// All functions fail with ErrorCode::unavailable if the plug-in is missing or incompatible, with ErrorCode::usage for
// options out of range (rebuild_level_set(): ErrorCode::input), and with ErrorCode::input (write_vdb():
// ErrorCode::output) if the plug-in fails. They reserve memory in the context and can be cancelled through it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "points/method.hpp"
#include "points/particle_set.hpp"

namespace isoextract::volume_io {

enum class SphereMethod {
  spheres,  // union of the particles' spheres
  // Spheres around the weighted mean of nearby particles: Y. Zhu and R. Bridson, "Animating sand as a fluid", SIGGRAPH
  // 2005, section 5. Without the bodies that the mean makes between particles: every body contains a sample of a sphere
  // (see plugins/openvdb/openvdb_smooth_spheres.hpp).
  smooth,
};

struct SphereOptions {
  SphereMethod method = SphereMethod::spheres;
  field::FieldKind kind = field::FieldKind::level_set;
  double radius = 0;             // of every particle, in world units, if `radii` is empty
  std::span<const float> radii;  // one per particle, in world units
  std::uint64_t images = 0;      // how many of the last particles are periodic images, which notes do not count
  double search_radius = 0;      // smooth method: reach of a particle in world units, or twice its radius if larger
  double voxel = 0;              // spacing of the samples; one of them is at the world's origin
  double half_band = 3;          // width of the narrow band on either side of the surface, in voxels; 2 to 1000
  // Minimum radius in voxels. Smaller spheres can fall between samples, so the plug-in leaves them out, with a note.
  double least_radius = points::kMinSphereRadius;
};

struct SphereField {
  field::ScalarField field;
  std::uint64_t left_out = 0;  // number of omitted particles
};

// Returns the path of the plug-in; an empty text if it is missing.
[[nodiscard]] std::string grid_tools_path();

// Fails if the plug-in is missing or incompatible, so that callers can check before preparing the work; `work` starts
// the message.
[[nodiscard]] Result<void> check_grid_tools(const std::string& work);

// Returns a level set or a density, sparse, in f32, the same for any number of threads. The level set is the signed
// distance from the spheres in world units, negative inside and constant beyond the narrow band; its iso value is 0.
// The density is 0 outside the spheres' surface, rises to 1 over half_band voxels inside it, and is 1 further in.
[[nodiscard]] Result<SphereField> rasterize_spheres(const points::ParticleSet& particles, const SphereOptions& options,
                                                    const Context& context);

// Returns an upper bound of the bytes of the grids that rasterize_spheres() works on; its result takes less.
[[nodiscard]] Result<std::uint64_t> sphere_bytes(const points::ParticleSet& particles, const SphereOptions& options,
                                                 const Context& context);

enum class LevelSetFilter { gaussian, median, mean };
constexpr auto words_of(LevelSetFilter /*type*/) {
  return std::array{Word{LevelSetFilter::gaussian, "gaussian"}, Word{LevelSetFilter::median, "median"},
                    Word{LevelSetFilter::mean, "mean"}};
}
inline constexpr int kMaxFilterWidth = 64;

// Filters a level set with cubic voxels in its narrow band, `iterations` times, and restores its distances. `median`
// and `mean` reach `width` voxels (1 to 64) to each side; `gaussian` applies four such means, and reaches four times as
// far. Reads the field as f32 and returns a sparse f32 field.
[[nodiscard]] Result<field::ScalarField> filter_level_set(const field::ScalarField& field, LevelSetFilter filter,
                                                          int width, int iterations, const Context& context);

// Returns the level set on another lattice, sparse, in f32: the signed distance from its surface in world units. Near
// the surface, the values are the linear interpolant of the field; farther away, the distance from the meshed surface
// (openvdb::tools::levelSetRebuild). The values are negative inside, and +- half_band voxels beyond the narrow band.
// `half_band` (2 to 1000) is the band's width on either side, in new voxels.
// `old_from_new` maps new to old indices: a scale per axis, above 0, and an offset. The axes must be perpendicular and
// the new voxels cubic. The result is the same for any number of threads.
[[nodiscard]] Result<field::ScalarField> rebuild_level_set(const field::ScalarField& field,
                                                           const field::Affine& old_from_new, double half_band,
                                                           const Context& context);

struct VdbWriteOptions {
  std::string name;      // name of the grid; if empty, the field's name
  bool as_half = false;  // rounds values to 16-bit floats
};

// Writes a VDB file of one or more float grids atomically; rounds other sample types to float. A level set gets the
// grid class "level set", a density "fog volume". grid_tools_plugin.h defines which voxels are active and the
// background of a dense field. Writes to standard output or a pipe as a stream. Returns the number of bytes. Also fails
// with ErrorCode::output if the file cannot be written, and with ErrorCode::input as check_mapping_intact() does.
[[nodiscard]] Result<std::uint64_t> write_vdb(const std::filesystem::path& path, const field::ScalarField& field,
                                              const VdbWriteOptions& options, const Context& context);
// Does the same for several fields; each grid has its field's name.
[[nodiscard]] Result<std::uint64_t> write_vdb(const std::filesystem::path& path,
                                              std::span<const field::ScalarField> fields, const Context& context);

}  // namespace isoextract::volume_io

// From a field to a mesh. One interface for every method (method.hpp) and backend.
//
// Inside is value > iso for density, value < iso for level sets; a value equal to iso is outside. Triangles wind
// counter-clockwise seen from outside, also where a transform mirrors. Vertices are welded by integers, never by
// distance: those that lie on an edge of the grid by that edge's key. The mesh is a closed, oriented 2-manifold
// wherever the surface does not leave the data, and everywhere if `cap` is set; by `mc` it has the topology of the
// trilinear interpolant. The same field and options give the same bytes for any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "base/words.hpp"
#include "extract/method.hpp"
#include "extract/voxel_faces.hpp"
#include "field/scalar_field.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::extract {

enum class NanPolicy {
  error,    // a NaN sample is ErrorCode::input; the message says where the first one is
  outside,  // a NaN sample is outside; the surface passes halfway between it and its inside neighbours
  hole,     // a cell with a NaN corner draws nothing, nor does a square of the cap; all else is as if none were NaN.
            // Where only a point would join what is left on both sides, each side has a vertex of its own there. Not of
            // methods whose surfaces are always closed.
};
constexpr auto words_of(NanPolicy /*type*/) {
  return std::array{Word{NanPolicy::error, "error"}, Word{NanPolicy::outside, "outside"},
                    Word{NanPolicy::hole, "hole"}};
}

// How often the vertices of surface nets move where nobody says: of the area that steps between voxels add, one
// hundredth is left.
inline constexpr std::uint64_t kUsualRelaxations = 10;

struct ExtractOptions {
  Method method = Method::mc;
  double iso = 0;
  bool smooth_normals = false;  // from the gradient of the field at the vertex (MethodTraits::gradient_normals)
  bool edge_keys = false;       // fill Mesh::edges (MethodTraits::vertices_on_edges): for who compares meshes
  bool cap = false;             // close the surface where it leaves the data or the region; of methods whose surfaces
                                // always are (MethodTraits::always_closed) it changes nothing
  VoxelFaces voxel_faces = VoxelFaces::merged;    // Method::voxels
  std::uint64_t relaxations = kUsualRelaxations;  // Method::surface_nets: rounds of smoothing; 0: none
  NanPolicy nan = NanPolicy::error;
  std::optional<field::IndexBox> region;  // extract only from cells within this box of samples (clipped to the data)
  bool shared_frame = false;  // regions of one field are relative to one origin, however far it reaches, so that they
                              // meet bit for bit, with fewer digits (edge_geometry.hpp)
  field::Affine output_from_index;  // places the mesh: index_to_world, or that with turns and scales after it

  friend bool operator==(const ExtractOptions&, const ExtractOptions&) = default;
};

// What only a backend with a device of its own has to tell.
struct DeviceStats {
  std::uint64_t bytes_uploaded = 0;    // of samples
  std::uint64_t samples_uploaded = 0;  // those of crossed bricks and around them; again where they were needed again
  // Where samples stay on the device for the next extraction: those that were needed and there already, and bricks of
  // 8 x 8 x 8 of them.
  std::uint64_t samples_kept = 0;
  std::uint64_t bricks_uploaded = 0;
  std::uint64_t bricks_kept = 0;
  std::uint64_t bytes_captured = 0;  // of triangles
  std::uint64_t cells_decided = 0;   // ambiguous cells that the host decided
  StageTime compile;                 // of shaders; none where they were kept from an earlier extraction
  StageTime upload;
  StageTime capture;  // `count` and `emit` below are sums of such stages
  StageTime read_back;
  StageTime weld;
};

// What was and was not looked at. A brick is a box of cells that is visited as a whole or not at all.
struct ExtractStats {
  std::string brick;                     // "64x8x8 cells", "8x8x8 voxels"
  std::uint64_t bricks = 0;              // that the data has
  std::uint64_t bricks_visited = 0;      // that the iso value crosses; the others were left out
  std::uint64_t places_visited = 0;      // sparse: of brick size without stored samples, next to stored ones or tiles
  std::uint64_t samples_classified = 0;  // compared with iso, each once
  std::uint64_t nan_samples = 0;
  std::uint64_t hole_cells = 0;  // NanPolicy::hole: left out, though they have an inside corner
  // Of the border of the data, or of the region: some of its samples are inside, which is what a cap stands on; and
  // others are not, so that the surface meets the border, where it is open without a cap. Neither for sparse data
  // without a region, which the background surrounds.
  bool inside_at_border = false;
  bool meets_border = false;
  StageTime classify;
  StageTime count;
  StageTime emit;
  std::optional<DeviceStats> device;
};

struct Extraction {
  mesh::Mesh mesh;
  ExtractStats stats;
};

class Extractor {
 public:
  virtual ~Extractor() = default;
  [[nodiscard]] virtual std::string_view name() const = 0;  // "cpu", "gpu"
  [[nodiscard]] virtual std::string device() const = 0;     // what it runs on: "AMD EPYC 7763 64-Core Processor"
  [[nodiscard]] virtual bool has(Method method) const = 0;

  // What takes memory by the size of the field or of the surface is reserved in the context while it lives, the mesh
  // exactly (Mesh::memory). Fails with ErrorCode::usage for an iso value that is not finite and as check_method() does,
  // with ErrorCode::unavailable for a method that it does not have, with ErrorCode::input for a placement that flattens
  // space and where memory runs out, with ErrorCode::cancelled between the passes.
  [[nodiscard]] Result<Extraction> extract(const field::ScalarField& field, const ExtractOptions& options,
                                           const Context& context);

 private:
  // May throw std::bad_alloc and std::length_error; need not name the mesh.
  [[nodiscard]] virtual Result<Extraction> run(const field::ScalarField& field, const ExtractOptions& options,
                                               const Context& context) = 0;
};

// Dense and sparse fields, on all threads that oneTBB is allowed.
[[nodiscard]] std::unique_ptr<Extractor> make_cpu_extractor();

}  // namespace isoextract::extract

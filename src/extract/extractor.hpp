// Extracts the isosurface of a field as a mesh: one interface for all methods (method.hpp) and backends.
//
// Inside is value > iso for density fields and value < iso for level sets; a value equal to iso is outside. Triangles
// wind counter-clockwise seen from outside, also if the transform mirrors. Vertices are welded by integer keys
// (vertices on grid edges by the key of their edge), never by distance.
//
// The mesh is an oriented 2-manifold, except with VoxelFaces::rectangles (voxel_faces.hpp). It is open only at the data
// boundary and the region's faces (`cap` closes it there), and around NaN samples with NanPolicy::hole. With Method::mc
// it has the topology of the trilinear interpolant. The same field and options give the same bytes for any number of
// threads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "extract/method.hpp"
#include "extract/voxel_faces.hpp"
#include "field/scalar_field.hpp"
#include "mesh/mesh.hpp"
#include "mesh/mesh_sink.hpp"

namespace isoextract::extract {

enum class NanPolicy {
  error,    // a NaN sample is an error (ErrorCode::input); the message states the index of the first one
  outside,  // a NaN sample is outside; the surface passes halfway between it and its inside neighbors
  hole,     // cells with a NaN corner get no triangles; neither do the squares of the cap that have a NaN corner. The
            // triangles of all other cells and squares do not change. If the triangles around a vertex form several
            // fans, each fan gets its own copy of the vertex. Not available for methods that are always closed.
};
constexpr auto words_of(NanPolicy /*type*/) {
  return std::array{Word{NanPolicy::error, "error"}, Word{NanPolicy::outside, "outside"},
                    Word{NanPolicy::hole, "hole"}};
}

// Default number of smoothing rounds of surface nets. More rounds change little in a picture (docs/labels.md).
inline constexpr std::uint64_t kDefaultRelaxations = 15;

struct ExtractOptions {
  Method method = Method::mc;
  double iso = 0;
  bool smooth_normals = false;  // normals from the gradient of the field (needs MethodTraits::gradient_normals)
  bool edge_keys = false;       // fill Mesh::edges, to compare meshes (needs MethodTraits::vertices_on_edges)
  bool cap = false;             // close the surface at the data boundary or at the region's faces; no effect for
                                // methods that are always closed (MethodTraits::always_closed)
  VoxelFaces voxel_faces = VoxelFaces::merged;      // for Method::voxels
  std::uint64_t relaxations = kDefaultRelaxations;  // for Method::surface_nets: rounds of smoothing; 0: none
  NanPolicy nan = NanPolicy::error;
  // Extract only from the cells within this box of samples. The part of the box beyond dense data is ignored.
  std::optional<field::IndexBox> region;
  // All regions of one field use one mesh origin, so vertices on a shared face are equal bit for bit. Large fields lose
  // precision (edge_geometry.hpp). No effect on a region that reaches more than one step beyond the data, if `cap` is
  // set or the method is always closed.
  bool shared_origin = false;
  field::Affine output_from_index;  // index_to_world, followed by the requested axis and unit changes
  // Receives the mesh part by part, once for each of MeshSink::passes(); null: no sink. Works on the CPU for mc and mt,
  // without edge keys. With NaN samples, it works only without NanPolicy::hole and without smooth normals. In all other
  // cases, and if the surface has no triangles or the sink declines (MeshSink::begin()), the mesh is Extraction::mesh.
  // Where a sink works, several ranks can share the extraction of dense samples (MeshSink::ranks()), without a cap or
  // holes. Each rank then extracts from its part of the samples; statistics are those of the whole surface. If the mesh
  // must be whole, rank 0 extracts it alone, and the other ranks fail with ErrorCode::cancelled.
  mesh::MeshSink* sink = nullptr;

  friend bool operator==(const ExtractOptions&, const ExtractOptions&) = default;
};

// Statistics of the GPU backend.
struct DeviceStats {
  // Samples uploaded to the device: those of the bricks that the iso value crosses, and those around them that cells
  // and gradients read. A sample that is uploaded twice counts twice.
  std::uint64_t samples_uploaded = 0;
  std::uint64_t bytes_uploaded = 0;  // size of the uploaded samples
  // Only if samples stay on the device between extractions. A brick here has 8x8x8 samples.
  std::uint64_t samples_kept = 0;     // needed samples that were already on the device
  std::uint64_t bricks_uploaded = 0;  // needed bricks that were uploaded
  std::uint64_t bricks_kept = 0;      // needed bricks that were already on the device
  std::uint64_t bytes_captured = 0;   // size of the triangles that transform feedback wrote
  std::uint64_t cells_decided = 0;    // ambiguous cells that the CPU decided
  StageTime compile;                  // of shaders; zero if they were kept from an earlier extraction
  StageTime upload;
  StageTime capture;  // part of ExtractStats::emit; so are read_back and weld
  StageTime read_back;
  StageTime weld;
};

// The work done and skipped. A brick is a box of cells that is visited or skipped as a whole.
struct ExtractStats {
  std::string brick;                     // "64x8x8 cells", "8x8x8 voxels"
  std::uint64_t bricks = 0;              // dense: bricks in the region; sparse: stored bricks
  std::uint64_t bricks_visited = 0;      // bricks that the iso value crosses, or with the label; the others are skipped
  std::uint64_t places_visited = 0;      // sparse fields: positions of bricks that are not stored, but visited because
                                         // stored bricks or tiles touch them; bricks_visited does not count them
  std::uint64_t samples_classified = 0;  // samples that were classified, counted once: dense samples in the region, all
                                         // samples of stored blocks; in a label map, only the first label counts them
  std::uint64_t nan_samples = 0;
  std::uint64_t hole_cells = 0;  // NanPolicy::hole: cells with both a NaN corner and an inside corner, which therefore
                                 // lack triangles
  // Flags of the outermost samples: those at the data boundary, or on the region's faces. inside_at_boundary: some are
  // inside, so a cap would have triangles. meets_boundary: some are inside and some outside, and cells there have
  // triangles (NanPolicy::hole can leave out all). So the surface reaches the boundary; without a cap it is open there.
  // Both are false for methods that are always closed, and for sparse data without a region (background surrounds
  // them).
  bool inside_at_boundary = false;
  bool meets_boundary = false;
  bool counts_while_comparing = false;  // one pass did both; `count` is its time, and `classify` is zero
  std::uint64_t early_vertices = 0;     // vertices that the sink got during that pass (MeshSink::begin_early())
  StageTime classify;
  StageTime count;
  StageTime emit;
  std::optional<DeviceStats> device;
};

struct Extraction {
  mesh::Mesh mesh;  // if a sink took the mesh: MeshSink::take_collected(), else without vertices and triangles
  ExtractStats stats;
  std::optional<mesh::MeshShape> taken = {};  // shape of the mesh that ExtractOptions::sink took
};

class Extractor {
 public:
  virtual ~Extractor() = default;
  [[nodiscard]] virtual std::string_view name() const = 0;  // "cpu", "gpu"
  [[nodiscard]] virtual std::string device() const = 0;     // name of the hardware: "AMD EPYC 7763 64-Core Processor"
  [[nodiscard]] virtual bool has(Method method) const = 0;

  // Extracts the surface. Reserves memory in the context for everything that grows with the field or the surface; the
  // mesh keeps its exact reservation (Mesh::memory).
  // Fails with ErrorCode::usage for an iso value that is not finite, and as check_method() does. Fails with
  // ErrorCode::unavailable for a method that this backend does not have. Fails with ErrorCode::input
  // - if the transform is singular or not finite (is_invertible() is false),
  // - if the data or `region` contain no cell, or an axis of dense samples has more than 2^30 samples (mc and mt),
  // - if `region` contains no sample (voxels and surface_nets),
  // - if sparse samples lie too far from index 0 (field::kMaxSparseIndex),
  // - if float32 cannot keep positions apart, because of their range or the number of samples,
  // - for a NaN sample with NanPolicy::error,
  // - if the mesh would have more than 2^32 - 1 vertices, or arrays that exceed the address space,
  // - if it finds that the file of mapped samples changed meanwhile (it does not find every change).
  // Fails with ErrorCode::out_of_memory, also if it cannot take samples by layers (DenseSamples::layers), and with
  // ErrorCode::cancelled between passes.
  [[nodiscard]] Result<Extraction> extract(const field::ScalarField& field, const ExtractOptions& options,
                                           const Context& context);

 private:
  // Does the work of extract() after its checks. May throw std::bad_alloc and std::length_error; need not set the mesh
  // name.
  [[nodiscard]] virtual Result<Extraction> run(const field::ScalarField& field, const ExtractOptions& options,
                                               const Context& context) = 0;
};

// Returns the CPU backend for dense and sparse fields; it uses all threads that oneTBB may use.
[[nodiscard]] std::unique_ptr<Extractor> make_cpu_extractor();

}  // namespace isoextract::extract

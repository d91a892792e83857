// Writes a surface to its file during extraction, so that the whole mesh is never in memory.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "convert/conversion_job.hpp"
#include "convert/detail/partwise_attributes.hpp"
#include "convert/source.hpp"
#include "convert/stages/surface_stages.hpp"
#include "edit/partwise_bodies.hpp"
#include "mesh/mesh_sink.hpp"
#include "mesh/partwise_measures.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::convert {

class PartwiseOutput final : public mesh::MeshSink {
 public:
  // `head` returns the mesh without vertices, triangles and attributes. `accept` gets the measures of the mesh before
  // the writer gets its first part; it may fail.
  struct Hooks {
    std::function<mesh::Mesh(const mesh::MeshShape& shape)> head;
    std::function<Result<void>(const mesh::MeshMeasures& measures)> accept;
  };
  // Properties that the mesh must have; the output declines other meshes.
  struct Needs {
    bool distinct_positions = false;  // no two vertices may have equal positions
    bool near_vertices = false;       // MeshShape::uses_near_vertices
  };
  // The work on the parts before they are written, in passes of its own; null: none. `bodies` selects those that are
  // written, `attributes` samples the attributes of the vertices, and `measures` measures the mesh.
  struct Work {
    std::unique_ptr<edit::PartwiseBodies> bodies;
    std::unique_ptr<PartwiseAttributes> attributes;
    std::unique_ptr<mesh::PartwiseMeasures> measures;
  };
  // The writer must outlive this object. With work but measures that have the ranks, `ranks` must be null. With
  // `work.bodies`, the output declines meshes that the memory holds as a whole (holds_whole_selection()). Without
  // `work.attributes`, it collects a remaining mesh that the writer does not take in parts.
  PartwiseOutput(mesh_io::MeshWriter& writer, Hooks hooks, Ranks* ranks, Needs needs, Work work, const Context& context)
      : writer_(writer),
        hooks_(std::move(hooks)),
        ranks_(ranks),
        needs_(needs),
        bodies_(std::move(work.bodies)),
        attributes_(std::move(work.attributes)),
        measuring_(std::move(work.measures)),
        context_(context) {}

  [[nodiscard]] Ranks* ranks() const override { return ranks_ != nullptr && ranks_->is_shared() ? ranks_ : nullptr; }
  Result<bool> begin_early(const mesh::MeshShape& estimate) override;
  Result<bool> begin(const mesh::MeshShape& shape) override;
  [[nodiscard]] std::vector<mesh::PartPass> passes() const override { return passes_; }
  Result<void> begin_pass(std::size_t pass) override;
  Result<void> take(const mesh::MeshPart& part) override;
  Result<void> end_pass() override;
  [[nodiscard]] bool has_declined() const override { return has_declined_; }
  [[nodiscard]] std::optional<mesh::Mesh> take_collected() override { return std::exchange(collected_, std::nullopt); }

  // Returns the figures of the selected bodies; nothing without `bodies`.
  [[nodiscard]] std::optional<edit::BodyFigures> bodies() const {
    return bodies_ != nullptr ? std::optional(bodies_->figures()) : std::nullopt;
  }
  // Returns the shape of the mesh that was written; nothing if it was collected. Call only with `bodies`.
  [[nodiscard]] std::optional<mesh::MeshShape> written_shape() const {
    return is_collecting_ ? std::nullopt : std::optional(bodies_->kept_shape());
  }

  // Returns the figures of the attributes; nothing if the job has none. Call once, if the mesh was taken.
  [[nodiscard]] std::optional<AttributesOfParts> take_attributes() {
    if (attributes_ == nullptr) return std::nullopt;
    return attributes_->take_figures();
  }

  // Returns the measures of the mesh; nothing without `measures`, or if no mesh was taken.
  [[nodiscard]] std::optional<mesh::MeshMeasures> take_measures() { return std::exchange(measures_, std::nullopt); }
  // Returns the time of the measuring passes, which make and measure all parts.
  [[nodiscard]] const StageTime& measuring_time() const { return measuring_time_; }

 private:
  // Begins the passes after the selection of bodies. Returns false if the output declines the mesh.
  Result<bool> begin_rest(const mesh::MeshShape& shape);
  // Begins the passes after the one that looks at attributes. Returns false if the output declines the mesh.
  Result<bool> begin_writing();
  // Prepares for collecting the remaining mesh, in one more pass if it has triangles.
  Result<void> begin_collecting(const mesh::MeshShape& shape);
  Result<void> collect(const mesh::MeshPart& part);
  Result<void> take_rest(const mesh::MeshPart& part);

  mesh_io::MeshWriter& writer_;
  Hooks hooks_;
  Ranks* ranks_;
  Needs needs_;
  std::unique_ptr<edit::PartwiseBodies> bodies_;
  std::unique_ptr<PartwiseAttributes> attributes_;
  std::unique_ptr<mesh::PartwiseMeasures> measuring_;  // until it has seen all parts
  Context context_;
  std::vector<mesh::PartPass> passes_;
  // The ends of the passes that select bodies, look at attributes, and measure, once they are known.
  std::size_t selecting_end_ = 0;
  std::size_t looking_end_ = 0;
  std::size_t measuring_end_ = 0;
  mesh::MeshShape shape_;  // of the written mesh
  std::size_t pass_ = 0;
  bool is_early_ = false;  // begin_early() returned true, and begin() was not called yet
  bool has_declined_ = false;
  bool is_collecting_ = false;
  std::optional<mesh::Mesh> collected_;
  std::optional<mesh::MeshMeasures> measures_;
  Stopwatch watch_;
  StageTime measuring_time_;
};

// Returns whether the job writes one surface, without packing or flat normals, to one file of a format whose parts
// several ranks can write. Whether the ranks can share the surface may depend on the input, too.
[[nodiscard]] bool writes_shared_parts(const ConversionJob& job);

// Returns whether the surface at `iso` goes to its file part by part, as far as that is known before the extraction.
// May wrongly return true in three cases known only later: a GLB with few vertices, and smooth normals with NaN
// samples. The third is a sparse field whose surface leaves the stored blocks, if the output needs near vertices. If
// the job selects bodies, the surface goes by parts only if memory is short (holds_whole_selection()). Returns false if
// NaN samples would need the whole mesh, unless `may_have_nan` is false.
[[nodiscard]] bool goes_by_parts(const ConversionJob& job, const Source& source, double iso, bool may_have_nan = true);

// Returns whether `left` bytes of memory surely hold a mesh while bodies of it are selected and, with `measures`, its
// figures are measured. `sampling_bytes` is the memory of its attributes. Selecting bodies of a mesh in memory is
// faster than part by part.
[[nodiscard]] bool holds_whole_selection(const mesh::MeshShape& shape, std::uint64_t sampling_bytes, bool measures,
                                         std::uint64_t left);

// Adds to the hint of an ErrorCode::out_of_memory which formats take a mesh in parts. Leaves other errors unchanged.
void add_partwise_hint(Error& error);

// Returns a sink that writes a surface as the only mesh of the writer's file. Returns null if a stage of the job needs
// the whole mesh, or if the job writes no mesh file. The sink measures the mesh if stage.facts.recorded is set or the
// job has requirements, and fails with ErrorCode::verification if the mesh does not meet these. `ranks` write the file
// together; may be null; ignored if they cannot share the other work on the parts. `stage` and the writer must outlive
// the sink.
[[nodiscard]] std::unique_ptr<PartwiseOutput> partwise_output(const StageContext& stage, const SurfaceId& id,
                                                              mesh_io::MeshWriter& writer, Ranks* ranks);

// Returns whether only the extraction reads the samples of the job, slab by slab: then they need not be in memory or
// mapped as a whole (volume_io::ReadOptions::by_layers). The extractor may be null if the job needs none.
[[nodiscard]] bool takes_layers(const ConversionJob& job, const extract::Extractor* extractor);

// Returns why ranks cannot share the extraction of a surface; empty if they can. `has_sink`: partwise_output() gave a
// sink for the surface, and its PartwiseOutput::ranks() is not null. `backend` is Extractor::name().
[[nodiscard]] std::string reason_against_sharing(const ConversionJob& job, const Source& source, bool has_sink,
                                                 std::string_view backend);

}  // namespace isoextract::convert

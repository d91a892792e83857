// Writes a surface to its file during extraction, so that the whole mesh is never in memory.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/source.hpp"
#include "convert/stages/vertex_colors.hpp"
#include "mesh/mesh_sink.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::convert {

class PartwiseOutput final : public mesh::MeshSink {
 public:
  // `head` returns the mesh without vertices, triangles and attributes. The writer must outlive this object. With
  // `needs_distinct`, declines meshes that may have vertices at equal positions.
  using MakeHead = std::function<mesh::Mesh(const mesh::MeshShape& shape)>;
  PartwiseOutput(mesh_io::MeshWriter& writer, MakeHead head, Ranks* ranks, bool needs_distinct)
      : writer_(writer), head_(std::move(head)), ranks_(ranks), needs_distinct_(needs_distinct) {}

  [[nodiscard]] Ranks* ranks() const override { return ranks_ != nullptr && ranks_->is_shared() ? ranks_ : nullptr; }
  Result<bool> begin(const mesh::MeshShape& shape) override {
    if (needs_distinct_ && !shape.distinct_positions) return false;
    return writer_.begin_parts(head_(shape), shape, ranks());
  }
  [[nodiscard]] std::vector<mesh::PartPass> passes() const override { return writer_.part_passes(); }
  Result<void> take(const mesh::MeshPart& part) override { return writer_.take_part(part); }

 private:
  mesh_io::MeshWriter& writer_;
  MakeHead head_;
  Ranks* ranks_;
  bool needs_distinct_;
};

// Returns whether the job writes one surface to one file of a format whose parts several ranks can write. Whether ranks
// can share it may depend on the input, too.
[[nodiscard]] bool writes_shared_parts(const ConversionJob& job);

// Returns whether the surface at `iso` goes to its file part by part, as far as that is known before the extraction.
// Two cases are not: a GLB with few vertices, and smooth normals beside NaN samples, do not.
[[nodiscard]] bool goes_by_parts(const ConversionJob& job, const Source& source, double iso);

// If a surface failed for lack of memory, adds to its hint which files take a mesh in parts.
void add_partwise_hint(Error& error);

// Returns a sink that writes the surface `id` as the only mesh of the writer's file. Returns null if a stage of the job
// needs the whole mesh, or if the job writes no mesh file. `ranks` write the file together; may be null. `all` lists
// the surfaces of the grid. `job`, `source`, `all` and the writer must outlive the sink.
[[nodiscard]] std::unique_ptr<mesh::MeshSink> partwise_output(const ConversionJob& job, const Source& source,
                                                              const SurfaceList& all, const SurfaceId& id,
                                                              mesh_io::MeshWriter& writer, Ranks* ranks);

// Returns why ranks cannot share the extraction of a surface; empty if they can. `has_sink`: partwise_output() gave a
// sink for it. `backend` is Extractor::name().
[[nodiscard]] std::string reason_against_sharing(const ConversionJob& job, const Source& source, bool has_sink,
                                                 std::string_view backend);

}  // namespace isoextract::convert

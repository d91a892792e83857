// Vertex attributes of a mesh that goes to its file part by part. They depend on the positions of the vertices only, so
// each part gets its attributes when it is made. Counts, the range of colors, and the attributes that glTF omits depend
// on all parts: where needed, a pass before the writing ones finds them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/active_time.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/attribute_source.hpp"
#include "convert/stages/surface_stages.hpp"
#include "edit/vertex_colors.hpp"
#include "mesh/mesh_sink.hpp"

namespace isoextract::convert {

// Returns the memory that one vertex takes while its attributes are sampled.
[[nodiscard]] std::uint64_t sampling_bytes(const AttributeSource& source);
// Returns how many of the vertices all threads together sample at a time if memory is not short.
[[nodiscard]] std::uint64_t vertices_sampled_at_once(std::uint64_t vertices);

// Returns whether the attributes of the job need the whole mesh. Those of mesh files do, and those that the format
// cannot store. Those that the input must have but lacks do, too: an empty mesh makes them no error.
[[nodiscard]] bool attributes_need_whole_mesh(const ConversionJob& job, const Source& source);

// Several threads may call measure(), measure_written() and add() at once. The functions fail as add_attributes() and
// edit::color_by_values() do.
class PartwiseAttributes {
 public:
  using TakePart = std::function<Result<void>(const mesh::MeshPart& part)>;

  // The source must have attributes. The job and the source must outlive this object.
  explicit PartwiseAttributes(const StageContext& stage);

  // Prepares for a mesh of this shape. Returns false if memory is short.
  [[nodiscard]] Result<bool> begin(const mesh::MeshShape& shape);

  // Returns the memory that add_attributes() takes for a whole mesh.
  [[nodiscard]] std::uint64_t whole_bytes(std::uint64_t vertices) const { return vertices * sampling_bytes(source_); }

  // Returns whether a pass over the positions must come before the writing ones. Each of its parts goes to measure();
  // if bodies are selected, the rest of it then goes to measure_written().
  [[nodiscard]] bool measures_first() const { return measures_first_; }
  [[nodiscard]] Result<void> measure(const mesh::MeshPart& part);
  [[nodiscard]] Result<void> measure_written(const mesh::MeshPart& part);
  void finish_measuring();

  // Returns the attributes of the mesh without values. Call it and not_finite() after the measuring.
  [[nodiscard]] Result<std::vector<mesh::Attribute>> attributes() const;
  // Returns MeshShape::not_finite_attributes.
  [[nodiscard]] std::vector<std::size_t> not_finite() const;

  // Begins a pass of the writer. add() calls take() with the part in chunks that have attributes. The chunks have the
  // arrays that the pass asks for; the part must have positions, too.
  void begin_pass(const mesh::PartPass& pass);
  [[nodiscard]] Result<void> add(const mesh::MeshPart& part, const TakePart& take);

  // Returns the figures of all parts. Call once, after the last pass.
  [[nodiscard]] AttributesOfParts take_figures();

 private:
  using UseChunk =
      std::function<Result<void>(std::size_t first, mesh::Mesh& chunk, const std::vector<AttributeResult>& results)>;

  // Returns whether the range of the colors is that of the values.
  [[nodiscard]] bool finds_range() const { return color_ != nullptr && !job_.color->range; }
  // Calls use() with consecutive vertices of the part, from number `first` of the part on, and their attributes.
  [[nodiscard]] Result<void> for_each_chunk(const mesh::MeshPart& part, std::size_t vertices, const UseChunk& use);
  void count(const std::vector<AttributeResult>& results);
  // Widens `range` by the values of a chunk that give colors, and records which attributes are not finite.
  void look_at(mesh::Mesh& chunk, std::optional<edit::ValueRange>& range);
  void keep_range(std::uint64_t first_vertex, const std::optional<edit::ValueRange>& range);
  // Colors the vertices of a chunk, and maps its attributes to output coordinates.
  [[nodiscard]] Result<edit::ValueColors> complete(mesh::Mesh& chunk) const;

  const ConversionJob& job_;
  const AttributeSource& source_;
  Context context_;
  Context chunk_context_;     // its reservations are part of `memory_`
  const std::string* color_;  // the attribute that gives colors; null: none
  bool omits_not_finite_;     // the format has no NaN and no infinite values
  bool selects_bodies_;
  bool measures_first_;
  std::uint64_t vertices_ = 0;
  std::size_t chunk_vertices_ = 0;    // sampled by one thread at a time
  std::size_t vertices_at_once_ = 0;  // by all threads
  Reservation memory_;
  std::optional<AttributeSamplers> samplers_;
  mesh::PartPass pass_;
  // Whether an earlier pass has counted the values and the gray vertices, and whether this pass counts them.
  bool has_counted_ = false;
  bool counts_ = false;
  bool has_counted_gray_ = false;
  bool counts_gray_ = false;

  std::mutex mutex_;  // guards the rest
  std::vector<AttributeResult> results_;
  std::map<std::uint64_t, edit::ValueRange> ranges_;  // of the values that give colors, by the part's first vertex
  edit::ValueColors colors_;
  std::vector<bool> not_finite_;  // by the index of the attribute
  ActiveTime time_;
};

}  // namespace isoextract::convert

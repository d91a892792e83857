// The run of every extraction, dense or sparse, on the CPU or a device: what is checked, in which order, and what is
// made of the passes that a surface brings.
#pragma once

#include <cmath>
#include <concepts>
#include <optional>
#include <utility>

#include "base/byte_size.hpp"
#include "base/context.hpp"
#include "base/stopwatch.hpp"
#include "extract/border_cap.hpp"
#include "extract/inside_test.hpp"
#include "extract/mesh_assembly.hpp"
#include "mesh/vertex_fans.hpp"

namespace isoextract::extract {

// What a surface brings. The passes are called once each, in this order; samples are given by their index in the field.
template <class S>
concept SurfacePasses = requires(S& surface, const S& seen, ExtractStats& stats, mesh::Mesh& mesh, const glm::ivec3& p,
                                 int direction) {
  { seen.placement() } -> std::convertible_to<const OutputFrame&>;
  // Compares the samples with iso and fills the figures of that. False where there can be no surface.
  { surface.classify(stats) } -> std::same_as<Result<bool>>;
  // Finds how large the surface is, and fills `count` and what else came out. A surface that is drawn in portions is
  // drawn here, and its part of `emit` is known then.
  { surface.count(stats) } -> std::same_as<Result<MeshSizes>>;
  // Writes the first vertices and triangles of a mesh that has room for as many as were counted.
  { surface.emit(mesh) } -> std::same_as<Result<void>>;

  // Known once it was counted. The box whose border a cap closes, and the sides of its samples there; nothing where
  // nothing leaves it.
  { seen.cap_box() } -> std::same_as<std::optional<field::IndexBox>>;
  { seen.border() } -> std::same_as<BorderSides>;
  { seen.draws_at_border() } -> std::same_as<bool>;  // asked where it has both sides, and holes
  { seen.has_holes() } -> std::same_as<bool>;        // some samples are NaN, and NanPolicy::hole
  { seen.inside(p) } -> std::same_as<bool>;
  { seen.value(p) } -> std::same_as<double>;
  { seen.edge_vertex(p, direction) } -> std::same_as<std::uint32_t>;  // on the crossed edge from `p`
};

// What is the same wherever the surface comes from: its frame fits float32, its size fits the context's memory, the cap
// is made of what the surface has at the border and stands behind it, and where cells were left out each fan of
// triangles gets a vertex of its own.
template <SurfacePasses Surface>
[[nodiscard]] Result<Extraction> extract_surface(const field::ScalarField& field, const ExtractOptions& options,
                                                 Surface& surface, const Context& context) {
  const OutputFrame& placement = surface.placement();
  Extraction result;
  result.mesh.origin = placement.origin();
  TRY(check_placement(field, placement));
  const auto found = TRY(surface.classify(result.stats));
  if (!found) return result;
  TRY(context.check());

  const auto sizes = TRY(surface.count(result.stats));
  TRY(context.check());
  auto memory = reserve_mesh(field, sizes, options, context);
  if (!memory) return tl::unexpected(memory.error());
  Stopwatch watch;
  BorderCap cap;
  Reservation cap_memory;
  const std::optional<field::IndexBox> box = surface.cap_box();
  if (box) {
    const BorderSides sides = surface.border();
    result.stats.inside_at_border = sides.inside;
    result.stats.meets_border = sides.inside && sides.outside && (!surface.has_holes() || surface.draws_at_border());
  }
  const bool capped = box && options.cap;
  if (capped) {
    auto numbers = TRY(reserve_cap_numbers(field, *box, context));
    const InsideRule rule{field.kind, options.iso};
    cap = make_border_cap(
        *box, method_info(options.method).traits.axis_edges_only, static_cast<std::uint32_t>(sizes.vertices),
        [&](const glm::ivec3& p) { return surface.inside(p); },
        [&](const glm::ivec3& p, int direction) { return surface.edge_vertex(p, direction); },
        [&](const glm::ivec3& p) { return rule.depth(surface.value(p)); },
        [&](const glm::ivec3& p) { return surface.has_holes() && std::isnan(surface.value(p)); });
    numbers.release();
    cap_memory = TRY(reserve_cap(field, cap, context));
    memory->release();
    memory = reserve_mesh(field, with_cap(sizes, cap), options, context);
    if (!memory) return tl::unexpected(memory.error());
  }
  result.stats.count += watch.elapsed();

  watch.restart();
  allocate_mesh(result.mesh, sizes, cap, options);
  TRY(surface.emit(result.mesh));
  if (options.smooth_normals && result.stats.nan_samples != 0) {
    TRY(fill_normals(result.mesh, sizes, field, context));
  }
  if (capped) append_cap(result.mesh, sizes, cap, *box, placement);
  cap = {};
  cap_memory.release();
  if (surface.has_holes()) {
    TRY(mesh::make_one_vertex_a_fan(result.mesh, field.source, context));
    memory->release();
    memory = reserve_mesh(field, {result.mesh.positions.size(), result.mesh.triangles.size()}, options, context);
    if (!memory) return tl::unexpected(memory.error());
  }
  result.mesh.memory = std::move(*memory);
  result.stats.emit += watch.elapsed();
  return result;
}

}  // namespace isoextract::extract

// The sequence of steps of every extraction with a case table (mc and mt), dense or sparse, on the CPU or a device.
#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "base/byte_size.hpp"
#include "base/context.hpp"
#include "base/stopwatch.hpp"
#include "extract/boundary_cap.hpp"
#include "extract/inside_test.hpp"
#include "extract/mesh_assembly.hpp"
#include "mesh/split_vertices.hpp"

namespace isoextract::extract {

// The interface of a surface under extraction. Each pass is called at most once, in this order: classify(); count(), if
// there can be a surface; emit(), unless a sink takes the mesh or the surface is the part of one rank. Samples are
// given by their index in the field.
template <class S>
concept SurfacePasses = requires(S& surface, const S& seen, ExtractStats& stats, mesh::Mesh& mesh, const glm::ivec3& p,
                                 int direction) {
  { seen.placement() } -> std::convertible_to<const OutputPlacement&>;
  // Compares the samples with iso and fills the classification figures, or leaves both to count(). Returns false if
  // there can be no surface.
  { surface.classify(stats) } -> std::same_as<Result<bool>>;
  // Counts vertices and triangles; fills `count` and other figures of `stats`. May already deliver vertices to the sink
  // (MeshSink::begin_early()). On a GPU, count() also captures the triangles, in portions that fit on the device, and
  // adds the times of capture, read-back and weld to `stats.emit`.
  { surface.count(stats) } -> std::same_as<Result<MeshSizes>>;
  // Writes vertices and triangles to the start of a mesh that has room for as many as were counted.
  { surface.emit(mesh) } -> std::same_as<Result<void>>;

  // Valid after count(): the box whose faces a cap closes (nullopt for a sparse field without a region), and whether
  // its outermost samples are inside, outside or both.
  { seen.cap_box() } -> std::same_as<std::optional<field::IndexBox>>;
  { seen.boundary_sides() } -> std::same_as<BoundarySides>;
  // Whether a cell at a face of cap_box() has triangles that reach the face. Called only if there are
  // holes, and boundary_sides() has inside and outside.
  { seen.draws_at_boundary() } -> std::same_as<bool>;
  { seen.has_holes() } -> std::same_as<bool>;  // NaN samples were found under NanPolicy::hole
  { seen.inside(p) } -> std::same_as<bool>;
  { seen.value(p) } -> std::same_as<double>;
  { seen.edge_vertex(p, direction) } -> std::same_as<std::uint32_t>;  // the vertex on the crossed edge from `p`
};

// A surface that can be made part by part.
template <class S>
concept PartwisePasses = SurfacePasses<S> && requires(S& surface, mesh::MeshSink& sink, const mesh::PartPass& pass) {
  // Makes the mesh that emit() would write, part by part, with the arrays that `pass` names; hands each part to the
  // sink. Fails as the sink does, and as emit(). Called once for each pass of the sink.
  { surface.deliver(sink, pass) } -> std::same_as<Result<void>>;
  { surface.uses_near_vertices() } -> std::same_as<bool>;  // MeshShape::uses_near_vertices, for these parts
  // Call after count(). Returns the slices of this rank, if other ranks make the other parts at the same time. count()
  // and the facts about the boundary are those of the whole surface even so. nullopt: this process makes all parts.
  { surface.rank_slices() } -> std::same_as<std::optional<RankSlices>>;
};

// Returns the slices of this rank; nullopt if this process makes the whole surface.
template <SurfacePasses Surface>
[[nodiscard]] std::optional<RankSlices> rank_slices_of(const Surface& surface) {
  if constexpr (PartwisePasses<Surface>) {
    return surface.rank_slices();
  } else {
    return std::nullopt;
  }
}

// Offers the mesh to the sink of `options`. If the sink takes it, sets Extraction::taken and delivers the mesh and its
// cap. Does nothing if the surface without its cap has no triangles, or with edge keys. Does nothing either if the
// mesh must be edited as a whole after emit(): it has holes, or options.smooth_normals is set and the field has NaN
// samples.
template <SurfacePasses Surface>
[[nodiscard]] Result<void> offer_to_sink(const ExtractOptions& options, Surface& surface, const MeshSizes& sizes,
                                         const BoundaryCap& cap, const std::optional<field::IndexBox>& box,
                                         const Context& context, Extraction& result) {
  if constexpr (PartwisePasses<Surface>) {
    const bool needs_whole_mesh = options.edge_keys || surface.has_holes() ||
                                  (options.smooth_normals && result.stats.nan_samples != 0) || sizes.triangles == 0;
    if (options.sink == nullptr || needs_whole_mesh) return {};
    const MeshSizes all = with_cap(sizes, cap);
    const mesh::MeshShape shape{.origin = surface.placement().origin(),
                                .vertices = all.vertices,
                                .triangles = all.triangles,
                                .has_normals = options.smooth_normals,
                                .may_be_open = result.stats.meets_boundary && !options.cap,
                                .distinct_positions = surface.placement().keeps_vertices_apart(),
                                .uses_near_vertices = surface.uses_near_vertices()};
    const bool takes = TRY(offer_mesh(*options.sink, shape, sizes, cap, surface.rank_slices(), context));
    if (!takes) return {};
    for (std::size_t p = 0; p < options.sink->passes().size(); ++p) {
      const mesh::PartPass pass = options.sink->passes()[p];
      TRY(options.sink->begin_pass(p));
      TRY(surface.deliver(*options.sink, pass));
      if (!cap.empty()) {
        TRY(deliver_cap(*options.sink, pass, sizes, cap, *box, surface.placement(), options, context));
      }
      TRY(options.sink->end_pass());
    }
    if (options.sink->has_declined()) return {};
    result.taken = shape;
    if (auto collected = options.sink->take_collected()) result.mesh = std::move(*collected);
  }
  return {};
}

// Runs the passes of `surface` and returns its mesh. The mesh is empty if a sink takes it, if no sample is inside, or
// if the surface is only the part of one rank. Checks that the placement fits float32, and reserves memory for the
// counted size. Builds the cap from the samples and crossed edges at the faces of cap_box(), and appends it behind the
// surface. If cells with NaN corners were left out, gives each fan of triangles its own vertex.
template <SurfacePasses Surface>
[[nodiscard]] Result<Extraction> extract_surface(const field::ScalarField& field, const ExtractOptions& options,
                                                 Surface& surface, const Context& context) {
  const OutputPlacement& placement = surface.placement();
  Extraction result;
  result.mesh.origin = placement.origin();
  TRY(check_placement(field, placement));
  const auto found = TRY(surface.classify(result.stats));
  if (!found) return result;
  TRY(context.check());

  const auto sizes = TRY(surface.count(result.stats));
  TRY(context.check());
  TRY(check_vertex_count(field, sizes));
  Stopwatch watch;
  BoundaryCap cap;
  Reservation cap_memory;
  const std::optional<field::IndexBox> box = surface.cap_box();
  if (box) {
    const BoundarySides sides = surface.boundary_sides();
    result.stats.inside_at_boundary = sides.inside;
    result.stats.meets_boundary =
        sides.inside && sides.outside && (!surface.has_holes() || surface.draws_at_boundary());
  }
  const bool capped = box && options.cap;
  const std::optional<RankSlices> share = rank_slices_of(surface);
  if (capped) {
    auto numbers = TRY(reserve_cap_numbers(field, used_part(*box, share), context));
    const InsideRule rule{field.kind, options.iso};
    cap = TRY(make_boundary_cap(
        *box, share, method_info(options.method).traits.axis_edges_only, static_cast<std::uint32_t>(sizes.vertices),
        [&](const glm::ivec3& p) { return surface.inside(p); },
        [&](const glm::ivec3& p, int direction) { return surface.edge_vertex(p, direction); },
        [&](const glm::ivec3& p) { return rule.depth(surface.value(p)); },
        [&](const glm::ivec3& p) { return surface.has_holes() && std::isnan(surface.value(p)); }));
    numbers.release();
    cap_memory = TRY(reserve_cap(field, cap, context));
    TRY(check_vertex_count(field, with_cap(sizes, cap)));
  }
  result.stats.count += watch.elapsed();

  watch.restart();
  TRY(offer_to_sink(options, surface, sizes, cap, box, context, result));
  if (!result.taken) result.stats.early_vertices = 0;  // the sink has forgotten them
  if (result.taken || share) {
    result.stats.emit += watch.elapsed();
    return result;
  }
  auto memory = reserve_mesh(field, with_cap(sizes, cap), options, context);
  if (!memory) return tl::unexpected(memory.error());
  allocate_mesh(result.mesh, sizes, cap, options);
  TRY(surface.emit(result.mesh));
  if (options.smooth_normals && result.stats.nan_samples != 0) {
    TRY(fill_normals(result.mesh, sizes, field, context));
  }
  if (capped) append_cap(result.mesh, sizes, cap, *box, placement);
  cap = {};
  cap_memory.release();
  if (surface.has_holes()) {
    TRY(mesh::split_nonmanifold_vertices(result.mesh, field.source, context));
    memory->release();
    memory = reserve_mesh(field, {result.mesh.positions.size(), result.mesh.triangles.size()}, options, context);
    if (!memory) return tl::unexpected(memory.error());
  }
  result.mesh.memory = std::move(*memory);
  result.stats.emit += watch.elapsed();
  return result;
}

}  // namespace isoextract::extract

#include "accuracy/field_error.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "accuracy/detail/brick_counter.hpp"
#include "accuracy/detail/mesh_parts.hpp"
#include "accuracy/detail/search_window.hpp"
#include "accuracy/detail/surface_components.hpp"
#include "accuracy/detail/window_error.hpp"
#include "accuracy/index_mesh.hpp"

namespace isoextract::accuracy {
namespace {

// The margins of the windows in which the isosurface and the mesh are searched, in cells.
struct Margins {
  int surface = 4;
  int mesh = 4;
};

// Maps the region of `grid` to samples of `field`: whole cells within it, or all cells that it touches.
field::IndexBox region_in_field(const field::IndexBox& region, const field::ScalarField& field,
                                const field::ScalarField& grid, bool whole_cells) {
  const field::Affine field_from_grid = field.index_to_file.inverse().after(grid.index_to_file);
  const field::Box box = field::image_of(field_from_grid, {glm::dvec3(region.min), glm::dvec3(region.max)});
  constexpr double kRounding = 1e-9;
  if (!whole_cells) return {glm::ivec3(glm::floor(box.min)), glm::ivec3(glm::ceil(box.max))};
  return {glm::ivec3(glm::ceil(box.min - kRounding)), glm::ivec3(glm::floor(box.max + kRounding))};
}

// Small surfaces get finer parts: little cost, much accuracy.
int parts_for(std::uint64_t triangles) {
  if (triangles <= 10'000) return 4;
  return triangles <= 100'000 ? 3 : 2;
}

field::IndexBox joined(const field::IndexBox& a, const field::IndexBox& b) {
  if (a.empty()) return b;
  return b.empty() ? a : field::IndexBox{glm::min(a.min, b.min), glm::max(a.max, b.max)};
}

class FieldMeasurement {
 public:
  FieldMeasurement(MeshParts& mesh, const field::ScalarField& field, const extract::ExtractOptions& extracted,
                   const FieldErrorOptions& options, const field::Affine& output_from_index, const Context& context)
      : mesh_(mesh),
        context_(context),
        reference_(field, extracted, options, output_from_index),
        surface_options_(extracted),
        components_(options.clipped) {
    reference_.has_mesh = mesh.has_triangles();
    surface_options_.method = extract::Method::mc;
    surface_options_.cap = false;
    surface_options_.smooth_normals = false;
    surface_options_.edge_keys = false;
    surface_options_.output_from_index = output_from_index;
    if (options.grid != nullptr && extracted.region) {
      auto& region = surface_options_.region;
      region = region_in_field(*extracted.region, field, *options.grid, true);
      reference_.counted = glm::all(glm::lessThan(region->min, region->max));
      if (!reference_.counted) region = region_in_field(*extracted.region, field, *options.grid, false);
    }
    reference_.region = surface_options_.region;
    all_ = joined(surface_box(field), mesh.samples());
  }

  Result<FieldError> run() {
    const std::vector<WindowBricks> windows = TRY(divide());
    if (windows.size() > 1) begin_windows(windows);
    FieldSums sums = no_sums(reference_);
    for (const WindowBricks& bricks : windows) {
      Margins margins;
      while (!TRY(measure(bricks.box, margins, windows.size() == 1, sums))) {
      }
      if (windows.size() > 1) context_.progress().advance(bricks.count);
    }
    while (const SearchWindow* window = components_.unfinished()) {
      const mesh::Mesh surface = TRY(extract_surface(*window));
      const auto memory =
          TRY(context_.reserve(SurfaceComponents::bytes(surface.positions.size(), surface.triangles.size()),
                               "the components of the isosurface"));
      const IndexMesh placed(surface, reference_.field, reference_.extracted, reference_.options.grid);
      TRY(components_.mark_found({*window, reference_.cells, surface, placed, nullptr}));
    }
    return result_of(sums);
  }

 private:
  // Extracts the isosurface of all samples, or of the region, in whole cells. If it is too large for that, only counts
  // its triangles, and divides the field.
  Result<std::vector<WindowBricks>> divide() {
    BrickCounter counter(reference_.options.window_triangles, reference_.cells, reference_.output_from_index.inverse(),
                         context_);
    extract::ExtractOptions options = surface_options_;
    options.sink = &counter;
    auto extraction = TRY(extract::make_cpu_extractor()->extract(reference_.field, options, context_));
    if (extraction.taken) {
      reference_.parts = parts_for(counter.triangles());
      surface_options_.edge_keys = true;
      return divide_bricks(counter.take_bricks(), reference_.options.window_triangles);
    }
    whole_ = std::move(extraction.mesh);
    reference_.parts = parts_for(whole_.triangles.size());
    return std::vector<WindowBricks>{{}};
  }

  void begin_windows(const std::vector<WindowBricks>& windows) const {
    std::size_t bricks = 0;
    for (const WindowBricks& window : windows) bricks += window.count;
    context_.progress().begin("measuring the error", bricks);
  }

  // Returns a margin in which points at most `needed` from a brick lie; `margin` if `needed` is 0.
  [[nodiscard]] int wider(int margin, double needed) const {
    if (!(needed > 0)) return margin;
    constexpr double kWidest = 1 << 30;  // wider than any field
    const double width = std::min({reference_.width.x, reference_.width.y, reference_.width.z});
    const double cells = std::isfinite(needed) ? std::ceil(needed / width) + 1 : 4.0 * margin;
    return static_cast<int>(std::min(kWidest, std::max(2.0 * margin, cells)));
  }

  Result<mesh::Mesh> extract_surface(const SearchWindow& window) const {
    return extract_within(window, reference_.field, surface_options_, context_.beside());
  }

  // Adds the distances in a window to `sums`, and returns true. If a margin is too small, widens it, adds nothing, and
  // returns false.
  Result<bool> measure(const BrickBox& bricks, Margins& margins, bool is_only_one, FieldSums& sums) {
    const SearchWindow window(bricks, margins.surface, all_, reference_.width);
    const SearchWindow mesh_window(bricks, margins.mesh, all_, reference_.width);
    const mesh::Mesh* mesh = TRY(mesh_.part(mesh_window));
    mesh::Mesh own_surface;
    if (!is_only_one) own_surface = TRY(extract_surface(window));
    const mesh::Mesh& surface = is_only_one ? whole_ : own_surface;
    WindowError error(reference_, window, mesh_window, *mesh, surface, context_);
    TRY(error.prepare());
    Progress* progress = is_only_one ? &context_.progress() : nullptr;
    if (is_only_one) progress->begin("measuring the error", error.brick_count());
    FieldSums here = TRY(error.measure(progress));
    margins = {wider(margins.surface, here.needed), wider(margins.mesh, here.back.needed)};
    if (here.needed > 0 || here.back.needed > 0) return false;
    if (reference_.counted) {
      const mesh::Mesh none;
      if (!reference_.has_mesh) mesh = &none;  // vertices alone find no component
      if (is_only_one) progress->begin("counting lost components", mesh->positions.size());
      const IndexMesh placed(surface, reference_.field, reference_.extracted, reference_.options.grid);
      const double needed = TRY(components_.add({window, reference_.cells, surface, placed, error.surface_tree()},
                                                *mesh, error.placed(), progress, context_));
      TRY(context_.check());
      margins.surface = wider(margins.surface, needed);
      if (needed > 0) return false;
    }
    sums.merge(here);
    if (const auto* dense = std::get_if<field::DenseSamples>(&reference_.field.samples); dense && !is_only_one) {
      const auto layer = static_cast<std::size_t>(dense->dims.x) * static_cast<std::size_t>(dense->dims.y);
      const auto clamped = [&](int k) { return layer * static_cast<std::size_t>(std::clamp(k, 0, dense->dims.z)); };
      dense->leave(clamped(window.samples().min.z), clamped(window.samples().max.z + 1));
    }
    return true;
  }

  [[nodiscard]] FieldError result_of(const FieldSums& sums) {
    FieldError result;
    result.interpolation = reference_.options.interpolation;
    result.parts = reference_.parts;
    result.interior = sums.interior.result();
    result.vertices = sums.vertices.result();
    result.interior.include_max(result.vertices);
    result.storage = sums.storage.result();
    result.cap_triangles = sums.cap_triangles;
    if (!reference_.counted) return result;
    SurfaceCoverage& coverage = result.coverage.emplace();
    coverage.distances = sums.back.distances.result();
    const double world = std::max(sums.back.at_most, coverage.distances.max.world);
    coverage.max_at_most = {std::max(world / reference_.shortest, coverage.distances.max.voxels), world};
    const SurfaceComponents::Counts counts = components_.counts();
    coverage.components = counts.components;
    coverage.lost = counts.lost;
    return result;
  }

  MeshParts& mesh_;
  const Context& context_;
  ErrorReference reference_;
  extract::ExtractOptions surface_options_;  // of the isosurface in whole cells
  SurfaceComponents components_;
  field::IndexBox all_;  // samples outside which neither the surface nor the mesh has triangles
  mesh::Mesh whole_;     // the isosurface; empty if there are several windows
};

// Returns the memory of the two interpolants.
std::uint64_t interpolants_bytes(const field::ScalarField& field) { return 2 * field::Interpolant::bytes(field); }

std::uint64_t window_bytes(std::uint64_t mesh_triangles, std::uint64_t surface_triangles) {
  const std::uint64_t surface_vertices = surface_triangles / 2;
  return surface_triangles * sizeof(glm::uvec3) + surface_vertices * sizeof(glm::vec3) +
         WindowError::bytes(mesh_triangles, mesh_triangles / 2, surface_triangles, surface_vertices);
}

}  // namespace

Result<FieldError> measure_field_error(const mesh::Mesh& mesh, const field::ScalarField& field,
                                       const extract::ExtractOptions& extracted, const FieldErrorOptions& options,
                                       const Context& context) {
  const auto memory = TRY(context.reserve(interpolants_bytes(field), "the error of the mesh"));
  const IndexMesh placed(mesh, field, extracted, options.grid);
  MeshInMemory parts(mesh, placed, context);
  return FieldMeasurement(parts, field, extracted, options, placed.output_from_index(), context).run();
}

Result<FieldError> measure_extraction_error(const field::ScalarField& field, const extract::ExtractOptions& extracted,
                                            const FieldErrorOptions& options, const Context& context) {
  const auto memory = TRY(context.reserve(interpolants_bytes(field), "the error of the mesh"));
  ExtractedMesh parts(field, extracted, context);
  return FieldMeasurement(parts, field, extracted, options, extracted.output_from_index, context).run();
}

ErrorMemory field_error_memory(const field::ScalarField& field, std::uint64_t mesh_triangles,
                               std::uint64_t surface_triangles) {
  const std::uint64_t interpolants = interpolants_bytes(field);
  const std::uint64_t whole = interpolants + window_bytes(mesh_triangles, surface_triangles);
  const auto of_window = [&](std::uint64_t triangles) {
    return interpolants + window_bytes(std::min(mesh_triangles, triangles), std::min(surface_triangles, triangles));
  };
  // Of two neighboring windows, one has at least half the triangles. Margins usually add a half to all of them.
  const bool may_divide = surface_triangles + surface_triangles / 3 > kWindowTriangles;
  const bool divides = surface_triangles > kWindowTriangles;
  return {may_divide ? of_window(kWindowTriangles / 2) : whole, divides ? of_window(kWindowTriangles * 3 / 2) : whole};
}

}  // namespace isoextract::accuracy

#include "extract/sparse_extractor.hpp"

#include <atomic>
#include <utility>

#include <fmt/format.h>

#include "base/stopwatch.hpp"
#include "extract/border_cap.hpp"
#include "extract/cell_output.hpp"
#include "extract/cell_streams.hpp"
#include "extract/mesh_assembly.hpp"
#include "extract/site_vertices.hpp"
#include "extract/sparse_sites.hpp"
#include "mesh/vertex_fans.hpp"

namespace isoextract {
namespace {

constexpr int kSize = SparseBlock::kSize;

// The values around one place: the block-size places up to one away along each axis.
template <class T>
class Neighbourhood {
 public:
  // `lowest` is -1 if places before this one are needed too (for gradients), otherwise 0.
  Neighbourhood(const SparseSamples& samples, const SparseLookup& lookup, const glm::ivec3& origin, int lowest)
      : origin_(origin) {
    for_each_near_place(origin, lowest, [&](std::size_t slot, const glm::ivec3& at) {
      Place& place = places_[slot];
      const std::int32_t block = lookup.block(at);
      if (block >= 0) {
        place.values = static_cast<const T*>(samples.blocks[block].values);
      } else {
        place.constant = lookup.constant(at);
      }
    });
  }

  // The stored number at a sample within the places asked for.
  [[nodiscard]] double operator()(const glm::ivec3& p) const {
    const glm::ivec3 away = (p - origin_) >> 3;
    const Place& place = places_[near_place_slot(away)];
    return place.values != nullptr ? static_cast<double>(place.values[block_offset(p)]) : place.constant;
  }

 private:
  struct Place {
    const T* values = nullptr;
    double constant = 0;
  };

  glm::ivec3 origin_;
  std::array<Place, kNearPlaces> places_;
};

template <class T, int kDirections>
class SparseExtraction {
 public:
  SparseExtraction(const ScalarField& field, const SparseSamples& samples, const IndexBox& region,
                   const ExtractOptions& options)
      : field_(field),
        samples_(samples),
        region_(region),
        options_(options),
        rule_{field.kind, options.iso},
        table_(case_table(options.method)),
        placement_(options.output_from_index, stored_box(samples), field.kind, field.scale),
        sites_(field, samples, region, options) {}

  Result<Extraction> run() {
    Extraction result;
    result.mesh.origin = placement_.origin();
    if (auto fits = check_placement(field_, placement_); !fits) return tl::unexpected(fits.error());
    if (auto found = sites_.find(result.stats); !found) return tl::unexpected(found.error());

    Stopwatch watch;
    result.stats.hole_cells = count();
    const MeshSizes sizes = place_sites();
    if (auto fits = check_mesh_size(field_, sizes, options_); !fits) return tl::unexpected(fits.error());
    BorderCap cap;
    if (options_.cap && options_.region) {
      if (auto fits = check_cap_size(field_, region_, options_); !fits) return tl::unexpected(fits.error());
      cap = make_border_cap(
          region_, options_.method, static_cast<std::uint32_t>(sizes.vertices),
          [&](const glm::ivec3& p) { return sites_.inside(p); },
          [&](const glm::ivec3& p, int direction) { return edge_vertex(p, direction); },
          [&](const glm::ivec3& p) { return rule_.depth(sites_.value(p)); },
          [&](const glm::ivec3& p) { return sites_.has_holes() && std::isnan(sites_.value(p)); });
      if (auto fits = check_mesh_size(field_, with_cap(sizes, cap), options_); !fits) {
        return tl::unexpected(fits.error());
      }
    }
    result.stats.count = watch.elapsed();

    watch.restart();
    allocate_mesh(result.mesh, sizes, cap, options_);
    emit(result.mesh);
    append_cap(result.mesh, sizes, cap, region_, glm::ivec3(0), placement_);
    if (sites_.has_holes()) {
      if (auto done = make_one_vertex_a_fan(result.mesh, options_.limits, field_.source); !done) {
        return tl::unexpected(done.error());
      }
    }
    result.stats.emit = watch.elapsed();
    return result;
  }

 private:
  static constexpr std::size_t direction_index(int direction) {
    return static_cast<std::size_t>(isoextract::direction_index<kDirections>(direction));
  }

  // Returns how many cells NanPolicy::hole leaves out.
  std::uint64_t count() {
    std::atomic<std::uint64_t> hole_cells{0};
    const std::vector<glm::ivec3>& origins = sites_.origins();
    vertices_ = SiteVertices(origins.size(), kDirections);
    triangle_base_ = Buffer<std::uint64_t>(origins.size());
    sites_.for_each("counting", origins.size(), [&](std::size_t s) {
      const auto group = sites_.group_bits(origins[s]);
      for (const std::uint8_t direction : table_.directions) {
        vertices_.crossed(s, direction_index(direction)) = sites_.crossed_edges(origins[s], group, direction);
      }
      vertices_.count(s);
      std::uint64_t triangles = 0;
      const std::uint64_t left_out = sites_.for_each_active_cell(table_, origins[s], group, [&](int, int, unsigned v) {
        triangles += static_cast<std::uint64_t>(table_.first[v + 1] - table_.first[v]);
      });
      triangle_base_[s] = triangles;
      if (left_out != 0) hole_cells.fetch_add(left_out, std::memory_order_relaxed);
    });
    return hole_cells.load();
  }

  MeshSizes place_sites() {
    MeshSizes sizes;
    sizes.vertices = vertices_.number();
    for (std::uint64_t& base : triangle_base_) sizes.triangles += std::exchange(base, sizes.triangles);
    return sizes;
  }

  [[nodiscard]] std::uint32_t edge_vertex(const glm::ivec3& p, int direction) const {
    const auto site = static_cast<std::size_t>(sites_.site(block_origin(p)));
    return vertices_.at(site, direction_index(direction), block_offset(p));
  }

  void emit(Mesh& mesh) {
    sites_.for_each("extracting", sites_.origins().size(), [&](std::size_t s) {
      emit_vertices(mesh, s);
      emit_triangles(mesh, s);
    });
  }

  void emit_vertices(Mesh& mesh, std::size_t s) const {
    const glm::ivec3 origin = sites_.origins()[s];
    const Neighbourhood<T> stored(samples_, sites_.lookup(), origin, options_.smooth_normals ? -1 : 0);
    for (const std::uint8_t direction : table_.directions) {
      const BlockBits& crossed = vertices_.crossed(s, direction_index(direction));
      std::size_t number = vertices_.first(s, direction_index(direction));
      for (int x = 0; x < kSize; ++x) {
        for_each_bit(crossed[x], [&](int bit) {
          emit_vertex(mesh, number++, stored, origin + glm::ivec3(x, bit >> 3, bit & 7), direction_step(direction));
        });
      }
    }
  }

  void emit_vertex(Mesh& mesh, std::size_t number, const Neighbourhood<T>& stored, const glm::ivec3& p,
                   const glm::ivec3& step) const {
    const auto gradient = [&](const glm::ivec3& q) {
      const auto difference = [&](const glm::ivec3& axis) { return (stored(q + axis) - stored(q - axis)) / 2; };
      return glm::dvec3(difference({1, 0, 0}), difference({0, 1, 0}), difference({0, 0, 1}));
    };
    write_vertex(
        mesh, number, placement_, rule_, p, step, [&](const glm::ivec3& q) { return field_.scale(stored(q)); },
        gradient);
  }

  void emit_triangles(Mesh& mesh, std::size_t s) const {
    const glm::ivec3 origin = sites_.origins()[s];
    const std::array<std::int32_t, 8> near = sites_.near(s);
    glm::uvec3* out = mesh.triangles.data() + triangle_base_[s];
    sites_.for_each_active_cell(table_, origin, sites_.group_bits(origin), [&](int x, int bit, unsigned v) {
      const auto vertex = [&](std::uint8_t edge) {
        const CellEdge& e = table_.edges[edge];
        const glm::ivec3 p = glm::ivec3(x, bit >> 3, bit & 7) + direction_step(e.corner);
        const int n = p.x >> 3 | p.y >> 3 << 1 | p.z >> 3 << 2;
        return vertices_.at(static_cast<std::size_t>(near[n]), direction_index(e.direction), block_offset(p));
      };
      out = write_cell(table_, v, placement_.mirrored(), vertex, out);
    });
  }

  const ScalarField& field_;
  const SparseSamples& samples_;
  IndexBox region_;
  const ExtractOptions& options_;
  InsideRule rule_;
  const CaseTable& table_;
  Placement placement_;
  SparseSites sites_;
  SiteVertices vertices_;
  Buffer<std::uint64_t> triangle_base_;  // per site: first a count, then the first triangle
};

}  // namespace

Result<Extraction> extract_sparse(const ScalarField& field, const SparseSamples& samples,
                                  const ExtractOptions& options) {
  const auto region = sparse_region(field, samples, options);
  if (!region) return tl::unexpected(region.error());
  if (region->empty()) {
    Extraction nothing;
    nothing.stats.brick = "8x8x8 voxels";
    return nothing;
  }
  return visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) -> Result<Extraction> {
    if (options.method == Method::mc) return SparseExtraction<T, 3>(field, samples, *region, options).run();
    return SparseExtraction<T, 7>(field, samples, *region, options).run();
  });
}

}  // namespace isoextract

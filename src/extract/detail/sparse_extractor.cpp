#include "extract/detail/sparse_extractor.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "base/stopwatch.hpp"
#include "extract/asymptotic_decider.hpp"
#include "extract/detail/site_cells.hpp"
#include "extract/detail/slab_workers.hpp"
#include "extract/detail/vertex_batch.hpp"
#include "extract/row_bits.hpp"
#include "extract/site_vertices.hpp"
#include "extract/sparse_sites.hpp"
#include "extract/surface_run.hpp"

namespace isoextract::extract {
namespace {

// The stored values of a place and its neighbors.
template <class T>
class Neighborhood {
 public:
  // `lowest` is -1 if places before this one are needed, too (for gradients), otherwise 0.
  Neighborhood(const field::SparseSamples& samples, const field::SparseLookup& lookup, const glm::ivec3& origin,
               int lowest)
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

  // Returns the stored number at a sample within the loaded places.
  [[nodiscard]] double operator()(const glm::ivec3& p) const {
    const glm::ivec3 away = (p - origin_) >> 3;
    const Place& place = places_[near_place_slot(away)];
    return place.values != nullptr ? static_cast<double>(place.values[field::block_offset(p)]) : place.constant;
  }

 private:
  struct Place {
    const T* values = nullptr;
    double constant = 0;
  };

  glm::ivec3 origin_;
  std::array<Place, kNearPlaces> places_;
};

template <class T>
class SparseExtraction final : private VariantChooser {
 public:
  SparseExtraction(const field::ScalarField& field, const field::SparseSamples& samples, const field::IndexBox& region,
                   const ExtractOptions& options, const Context& context)
      : field_(field),
        samples_(samples),
        region_(region),
        options_(options),
        context_(context),
        rule_{field.kind, options.iso},
        table_(case_table(options.method)),
        placement_(output_placement(field, options, stored_box(samples), region)),
        sites_(field, samples, region, options, context) {}

  [[nodiscard]] const OutputPlacement& placement() const { return placement_; }

  Result<bool> classify(ExtractStats& stats) {
    TRY(sites_.find(stats));
    return true;
  }

  Result<MeshSizes> count(ExtractStats& stats) {
    const Stopwatch watch;
    const std::size_t sites = sites_.origins().size();
    numbers_memory_ = TRY(
        context_.reserve(SiteVertices::bytes(sites, table_.directions.size()) + sites * sizeof(std::uint64_t),
                         fmt::format("{}: the table of the {} blocks that the surface crosses", field_.source, sites)));
    drawings_.emplace(table_, placement_.mirrored(), sites_.has_holes());
    stats.hole_cells = count_sites();
    const MeshSizes sizes = place_sites();
    stats.count = watch.elapsed();
    return sizes;
  }

  Result<void> emit(mesh::Mesh& mesh) {
    sites_.for_each("extracting", sites_.origins().size(), [&](std::size_t s) { emit_site(mesh, {}, s); });
    return {};
  }

  // A part of the mesh is a layer: the sites of one index along x, whose vertices have consecutive numbers.
  Result<void> deliver(mesh::MeshSink& sink, const mesh::PartPass& pass) {
    const std::vector<std::size_t> layers = layer_ends();
    const auto sizes_of = [&](std::size_t begin, std::size_t end) {
      const MeshSizes first = below_site(begin);
      const MeshSizes last = below_site(end);
      return sizes_in(pass, {last.vertices - first.vertices, last.triangles - first.triangles});
    };
    const auto begin_of = [&](std::size_t layer) { return layer == 0 ? 0 : layers[layer - 1]; };
    const ExtractOptions wanted = options_in(pass, options_);
    MeshSizes most;
    for (std::size_t layer = 0; layer < layers.size(); ++layer) {
      const MeshSizes sizes = sizes_of(begin_of(layer), layers[layer]);
      most = {std::max(most.vertices, sizes.vertices), std::max(most.triangles, sizes.triangles)};
    }
    struct Worker {
      Reservation memory;
      mesh::Mesh part;
    };
    const auto make = [&]() -> Result<Worker> {
      Worker worker{TRY(reserve_mesh(field_, most, wanted, context_)), {}};
      allocate_mesh(worker.part, most, {}, wanted);
      return worker;
    };
    const int threads = pass.in_order ? 1 : usable_threads();
    return run_slabs(static_cast<int>(layers.size()), threads, "extracting", context_, make,
                     [&](int number, Worker& worker) -> Result<void> {
                       const std::size_t end = layers[static_cast<std::size_t>(number)];
                       const std::size_t begin = begin_of(static_cast<std::size_t>(number));
                       const MeshSizes first = below_site(begin);
                       const MeshSizes sizes = sizes_of(begin, end);
                       if (sizes.vertices == 0 && sizes.triangles == 0) return {};
                       const auto emit = [&](std::size_t i) { emit_site(worker.part, first, begin + i); };
                       if (pass.in_order) for_each_index(end - begin, emit, kSiteGrain);
                       for (std::size_t i = 0; i < end - begin && !pass.in_order; ++i) emit(i);
                       return deliver_part(sink, pass, worker.part, first, sizes);
                     });
  }

  // Sites without a stored block come last, so a triangle there may use the vertices of any layer.
  [[nodiscard]] bool uses_near_vertices() const { return sites_.stored() == sites_.origins().size(); }
  [[nodiscard]] std::optional<RankSlices> rank_slices() const { return std::nullopt; }
  [[nodiscard]] std::optional<field::IndexBox> cap_box() const { return sparse_cap_box(region_, options_); }
  [[nodiscard]] BoundarySides boundary_sides() const { return sites_.boundary_sides(); }
  [[nodiscard]] bool draws_at_boundary() const { return sites_.draws_at_boundary(); }
  [[nodiscard]] bool has_holes() const { return sites_.has_holes(); }
  [[nodiscard]] bool inside(const glm::ivec3& p) const { return sites_.inside(p); }
  [[nodiscard]] double value(const glm::ivec3& p) const { return sites_.value(p); }
  [[nodiscard]] std::uint32_t edge_vertex(const glm::ivec3& p, int direction) const {
    const auto site = static_cast<std::size_t>(sites_.site(field::block_origin(p)));
    return vertices_.at(site, table_.index_of(direction), field::block_offset(p));
  }

 private:
  static constexpr std::size_t kSiteGrain = 64;

  // Returns the end of each layer of sites.
  [[nodiscard]] std::vector<std::size_t> layer_ends() const {
    const std::vector<glm::ivec3>& origins = sites_.origins();
    std::vector<std::size_t> ends;
    for (std::size_t s = 0; s < origins.size(); ++s) {
      const std::size_t next = s + 1;
      if (next == origins.size() || next == sites_.stored() || origins[next].x != origins[s].x) ends.push_back(next);
    }
    return ends;
  }

  // Returns the numbers of the first vertex and the first triangle of a site; after the last site, how many there are.
  [[nodiscard]] MeshSizes below_site(std::size_t s) const {
    if (s == sites_.origins().size()) return sizes_;
    return {vertices_.first(s, 0), triangle_base_[s]};
  }

  // Writes the vertices and triangles of a site to a mesh that begins with vertex and triangle `first`, if the mesh has
  // memory for them.
  void emit_site(mesh::Mesh& mesh, const MeshSizes& first, std::size_t s) const {
    if (!mesh.positions.empty()) emit_vertices(mesh, first.vertices, s);
    if (mesh.triangles.empty()) return;
    const SitePlanes planes = sites_.planes(s);
    write_site_cells(table_, *drawings_, sites_.origins()[s], planes, sites_.active_cells(s, planes), *this, vertices_,
                     sites_.upper_neighbors(s), mesh.triangles.data() + (triangle_base_[s] - first.triangles));
  }

  // Counts the vertices and triangles of all sites. Returns how many cells NanPolicy::hole leaves out.
  std::uint64_t count_sites() {
    std::atomic<std::uint64_t> left_out{0};
    const std::vector<glm::ivec3>& origins = sites_.origins();
    vertices_ = SiteVertices(origins.size(), table_.directions.size());
    triangle_base_ = Buffer<std::uint64_t>(origins.size());
    sites_.for_each("counting", origins.size(), [&](std::size_t s) {
      const SitePlanes planes = sites_.planes(s);
      for (std::size_t d = 0; d < table_.directions.size(); ++d) {
        vertices_.crossed(s, d) = sites_.crossed_edges(s, planes, table_.directions[d]);
      }
      vertices_.count(s);
      const CellCounts counts = count_site_cells(*drawings_, origins[s], planes, sites_.active_cells(s, planes), *this);
      triangle_base_[s] = counts.triangles;
      if (counts.left_out != 0) left_out.fetch_add(counts.left_out, std::memory_order_relaxed);
    });
    return left_out.load();
  }

  const MeshSizes& place_sites() {
    sizes_.vertices = vertices_.number();
    for (std::uint64_t& base : triangle_base_) sizes_.triangles += std::exchange(base, sizes_.triangles);
    return sizes_;
  }

  [[nodiscard]] std::optional<unsigned> variant(unsigned cell_case, const glm::ivec3& p) const override {
    return cell_variant_or_hole(table_, cell_case, rule_, sites_.has_holes(),
                                [&](int corner) { return sites_.value(p + direction_step(corner)); });
  }

  void emit_vertices(mesh::Mesh& mesh, std::uint64_t first, std::size_t s) const {
    const glm::ivec3 origin = sites_.origins()[s];
    VertexWriter writer({placement_, rule_, field_.scale}, mesh, vertices_.first(s, 0) - first);  // consecutive numbers
    const bool gradients = writer.wants_gradients();
    const Neighborhood<T> stored(samples_, sites_.lookup(), origin, gradients ? -1 : 0);
    VertexBatch& batch = writer.batch();
    for (std::size_t d = 0; d < table_.directions.size(); ++d) {
      const int direction = table_.directions[d];
      const glm::ivec3 step = direction_step(direction);
      const BlockBits& crossed = vertices_.crossed(s, d);
      for (int x = 0; x < kBlockSize; ++x) {
        for_each_bit(crossed[x], [&](int bit) {
          const glm::ivec3 p = origin + glm::ivec3(x, bit >> 3, bit & 7);
          const int i = batch.count++;
          batch.direction[i] = direction;
          for (int axis = 0; axis < 3; ++axis) batch.low[axis][i] = p[axis];
          batch.value[0][i] = stored(p);
          batch.value[1][i] = stored(p + step);
          if (gradients) {
            put_gradient(batch, 0, i, stored, p);
            put_gradient(batch, 1, i, stored, p + step);
          }
          writer.flush_if_full();
        });
      }
    }
    writer.flush();
  }

  // Stores the gradient of the stored numbers, by central differences; next to NaN as in sample_derivative().
  static void put_gradient(VertexBatch& batch, int end, int i, const Neighborhood<T>& stored, const glm::ivec3& p) {
    for (int axis = 0; axis < 3; ++axis) {
      glm::ivec3 step(0);
      step[axis] = 1;
      batch.gradient[end][axis][i] = sample_derivative(stored(p - step), stored(p), stored(p + step));
    }
  }

  const field::ScalarField& field_;
  const field::SparseSamples& samples_;
  field::IndexBox region_;
  const ExtractOptions& options_;
  const Context& context_;
  InsideRule rule_;
  const CaseTable& table_;
  OutputPlacement placement_;
  SparseSites sites_;
  std::optional<CellDrawings> drawings_;
  Reservation numbers_memory_;  // for the arrays below
  SiteVertices vertices_;
  Buffer<std::uint64_t> triangle_base_;  // per site: first a count, then the first triangle
  MeshSizes sizes_;
};

}  // namespace

Result<Extraction> extract_sparse(const field::ScalarField& field, const field::SparseSamples& samples,
                                  const ExtractOptions& options, const Context& context) {
  const auto region = TRY(sparse_region(field, samples, options));
  if (region.empty()) return empty_sparse_extraction();
  return visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) -> Result<Extraction> {
    SparseExtraction<T> surface(field, samples, region, options, context);
    return extract_surface(field, options, surface, context);
  });
}

}  // namespace isoextract::extract

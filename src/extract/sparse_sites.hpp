// Finds the places of sparse samples that the surface passes. Looks up the value of a sample and whether it is inside.
// The CPU and the GPU backend both begin their work on sparse samples with these places.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "extract/edge_geometry.hpp"
#include "extract/extractor.hpp"
#include "extract/sparse_blocks.hpp"

namespace isoextract::extract {

// Returns the box of samples to extract from: the stored samples and one layer of background around them, which closes
// every surface. With options.region, returns the part of this box in the region, or all of the region if the
// background is inside. Returns an empty box if nothing is stored. Fails with ErrorCode::input if voxels lie too far
// from index 0 (field::kMaxSparseIndex), or if options.region contains no cell.
[[nodiscard]] Result<field::IndexBox> sparse_region(const field::ScalarField& field,
                                                    const field::SparseSamples& samples, const ExtractOptions& options);

// Returns the empty extraction of a field without stored samples.
[[nodiscard]] Extraction empty_sparse_extraction();

// Returns the box whose faces a cap closes: `region`, which is the result of sparse_region(). Returns nullopt if
// options.region is unset, because no surface then reaches these faces.
[[nodiscard]] std::optional<field::IndexBox> sparse_cap_box(const field::IndexBox& region,
                                                            const ExtractOptions& options);

// A site is a brick of 8x8x8 samples that owns a crossed edge: one of its samples is the lower end of the edge.
class SparseSites {
 public:
  // All arguments except the region and the context must outlive this object.
  SparseSites(const field::ScalarField& field, const field::SparseSamples& samples, const field::IndexBox& region,
              const ExtractOptions& options, const Context& context);

  // Compares every sample with iso, then lists the sites. Under NanPolicy::error, fails with ErrorCode::input for NaN
  // in the background, or in a block or tile that touches the region, even if the NaN lies outside the region. Fails
  // with ErrorCode::out_of_memory, and with ErrorCode::cancelled between the two steps.
  [[nodiscard]] Result<void> find(ExtractStats& stats);

  // Does only the comparison, for callers that need no sites. Sets the inside bits and the figures of `stats`. Fails as
  // find() does.
  [[nodiscard]] Result<void> compare(ExtractStats& stats);
  [[nodiscard]] const BlockBits& block_bits(std::size_t block) const { return bits_[block]; }
  [[nodiscard]] const ConstantSides& sides() const { return sides_; }

  // Returns the origins of all sites: first those with a stored block, then those without, each group sorted by x, y,
  // z.
  [[nodiscard]] const std::vector<glm::ivec3>& origins() const { return sites_; }
  // Returns the number of sites with a stored block.
  [[nodiscard]] std::size_t stored() const { return stored_sites_; }
  // Returns the number of the site with this origin, or -1.
  [[nodiscard]] std::int32_t site(const glm::ivec3& origin) const { return site_index_.find(origin); }
  // Returns the sites that own the edges of the cells of `site`: first `site` itself, then the next bricks along the
  // axes. Entry n lies direction_step(n) bricks away; it is -1 if this brick is no site.
  [[nodiscard]] std::array<std::int32_t, 8> upper_neighbors(std::size_t site) const {
    std::array<std::int32_t, 8> sites;
    for (int n = 0; n < 8; ++n)
      sites[n] = site_index_.find(sites_[site] + field::SparseBlock::kSize * direction_step(n));
    return sites;
  }

  [[nodiscard]] const field::SparseLookup& lookup() const { return *lookup_; }  // valid after compare() or find()
  [[nodiscard]] bool has_holes() const { return has_holes_; }  // NaN samples were found under NanPolicy::hole

  // Returns whether sample `p` is inside. Slow, as is value(): call them for few samples only.
  [[nodiscard]] bool inside(const glm::ivec3& p) const {
    const int offset = field::block_offset(p);
    return ((*bits_of(lookup_->place(field::block_origin(p))))[offset >> 6] >> (offset & 63) & 1) != 0;
  }
  [[nodiscard]] double value(const glm::ivec3& p) const;

  // Returns the inside bits of a site and of the samples one step past its upper faces.
  [[nodiscard]] SitePlanes planes(std::size_t site) const { return planes_of(groups_[site]); }

  // Returns the crossed edges of one direction that the samples of the site own and that lie in the region, one bit a
  // sample.
  [[nodiscard]] BlockBits crossed_edges(std::size_t site, const SitePlanes& planes, int direction) const {
    return crossed_edges_at(sites_[site], planes, direction);
  }

  // Returns the cells in the region that the surface crosses and whose lowest sample belongs to the site. Each cell is
  // the bit of its lowest sample.
  [[nodiscard]] BlockBits active_cells(std::size_t site, const SitePlanes& planes) const;

  // Returns the sides of the samples at the faces of the constructor's region: both if an edge in a face is crossed,
  // else the one side of all these samples. Returns neither side if options.region is unset.
  [[nodiscard]] BoundarySides boundary_sides() const;
  // Returns whether a cell at a face of the constructor's region has triangles there; cells with NaN samples have none.
  [[nodiscard]] bool draws_at_boundary() const;

  // Runs f(i) for 0 <= i < count in parallel.
  template <class F>
  void for_each(const char* stage, std::size_t count, const F& f) const {
    constexpr std::size_t kGrain = 64;
    context_.progress().begin(stage, count);
    for_each_range(count, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i != end; ++i) f(i);
      context_.progress().advance(end - begin);
    });
  }

 private:
  template <class T>
  void classify(ExtractStats& stats);
  [[nodiscard]] std::string finding_text() const;
  [[nodiscard]] Result<void> list_sites();
  [[nodiscard]] glm::ivec3 first_nan() const;
  [[nodiscard]] bool touches_region(const glm::ivec3& origin, int size) const;
  [[nodiscard]] const BlockBits* bits_of(std::int32_t place) const;
  [[nodiscard]] SitePlanes planes_of(const field::SparseLookup::Group& group) const;
  [[nodiscard]] bool owns_crossed_edge(const glm::ivec3& origin, const field::SparseLookup::Group& group) const;
  [[nodiscard]] BlockBits crossed_edges_at(const glm::ivec3& origin, const SitePlanes& planes, int direction) const;
  [[nodiscard]] std::uint64_t region_bits(const glm::ivec3& origin, const glm::ivec3& step, int x) const;
  [[nodiscard]] bool wholly_in_region(const glm::ivec3& origin) const;
  // Returns whether found(p, axis) is true for a crossed edge in the faces of the region; the edge goes from `p` along
  // `axis`.
  template <class Found>
  [[nodiscard]] bool any_boundary_edge(const Found& found) const;

  const field::ScalarField& field_;
  const field::SparseSamples& samples_;
  field::IndexBox region_;
  const ExtractOptions& options_;
  Context context_;
  InsideRule rule_;
  Reservation samples_memory_;  // for the lookup and the bits
  Reservation sites_memory_;
  std::optional<field::SparseLookup> lookup_;
  double (*stored_number_)(const void* values, int offset);
  Buffer<BlockBits> bits_;  // of stored blocks
  ConstantSides sides_;     // of tiles and the background
  std::vector<glm::ivec3> sites_;
  std::vector<field::SparseLookup::Group> groups_;  // one entry a site
  std::size_t stored_sites_ = 0;
  field::OriginIndex site_index_;
  bool has_holes_ = false;
};

}  // namespace isoextract::extract

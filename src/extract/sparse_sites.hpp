// The places of sparse samples that a surface passes, and what each sample there is: inside, a value, not a number.
// Both backends start from here.
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

// The samples to extract from, and one of background all round, which closes every surface. Empty if nothing is stored.
// Fails with ErrorCode::input where voxels lie too far from index 0, and where options.region holds no cell.
[[nodiscard]] Result<field::IndexBox> sparse_region(const field::ScalarField& field,
                                                    const field::SparseSamples& samples, const ExtractOptions& options);

// The extraction where nothing is stored.
[[nodiscard]] Extraction nothing_stored();

// The box whose border a cap closes: the region that was asked for. Without one nothing leaves what is stored.
[[nodiscard]] std::optional<field::IndexBox> sparse_cap_box(const field::IndexBox& region,
                                                            const ExtractOptions& options);

// A site is a place of 8 x 8 x 8 samples that owns a crossed edge: the lower end of the edge is one of its samples.
class SparseSites {
 public:
  // All arguments but the context must outlive it.
  SparseSites(const field::ScalarField& field, const field::SparseSamples& samples, const field::IndexBox& region,
              const ExtractOptions& options, const Context& context);

  // Compares every sample with iso, then lists the sites. Fails with ErrorCode::input for NaN samples in the region, if
  // those are errors, and where there is no memory for it; with ErrorCode::cancelled between the two.
  [[nodiscard]] Result<void> find(ExtractStats& stats);

  // The first part of that, for who needs no sites: what is inside, and the figures of it.
  [[nodiscard]] Result<void> compare(ExtractStats& stats);
  [[nodiscard]] const BlockBits& block_bits(std::size_t block) const { return bits_[block]; }
  [[nodiscard]] const ConstantSides& sides() const { return sides_; }

  // Stored blocks first, then places without one; each part sorted by x, y, z.
  [[nodiscard]] const std::vector<glm::ivec3>& origins() const { return sites_; }
  [[nodiscard]] std::size_t stored() const { return stored_sites_; }
  // The site at a place, or -1.
  [[nodiscard]] std::int32_t site(const glm::ivec3& origin) const { return site_index_.find(origin); }
  // The sites that own the edges of this site's cells, itself first.
  [[nodiscard]] std::array<std::int32_t, 8> near(std::size_t site) const {
    std::array<std::int32_t, 8> sites;
    for (int n = 0; n < 8; ++n)
      sites[n] = site_index_.find(sites_[site] + field::SparseBlock::kSize * direction_step(n));
    return sites;
  }

  [[nodiscard]] const field::SparseLookup& lookup() const { return *lookup_; }  // once samples were compared
  [[nodiscard]] bool has_holes() const { return has_holes_; }  // some samples are NaN, and NanPolicy::hole

  // Of any sample: for the few that are looked at one by one.
  [[nodiscard]] bool inside(const glm::ivec3& p) const {
    const int offset = field::block_offset(p);
    return ((*bits_of(lookup_->place(field::block_origin(p))))[offset >> 6] >> (offset & 63) & 1) != 0;
  }
  [[nodiscard]] double value(const glm::ivec3& p) const;

  // The bits of a site and around it.
  [[nodiscard]] SitePlanes planes(std::size_t site) const { return planes_of(groups_[site]); }

  // Edges of one direction owned by the site's samples that are crossed and lie in the region.
  [[nodiscard]] BlockBits crossed_edges(std::size_t site, const SitePlanes& planes, int direction) const {
    return crossed_edges_at(sites_[site], planes, direction);
  }

  // The cells whose lowest samples are the site's, that the surface passes and that lie in the region.
  [[nodiscard]] BlockBits active_cells(std::size_t site, const SitePlanes& planes) const;

  // The sides that the border of options.region has, by its crossed edges; neither side without a region.
  [[nodiscard]] BorderSides border() const;
  // Whether cells at that border draw something, where those with a NaN sample do not.
  [[nodiscard]] bool draws_at_border() const;

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
  // Whether found(p, axis) of one of the crossed edges that lie in the region's border: from `p` along `axis`.
  template <class Found>
  [[nodiscard]] bool any_border_edge(const Found& found) const;

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
  Buffer<BlockBits> bits_;  // of the stored blocks
  ConstantSides sides_;     // of all else
  std::vector<glm::ivec3> sites_;
  std::vector<field::SparseLookup::Group> groups_;  // by site
  std::size_t stored_sites_ = 0;
  field::OriginIndex site_index_;
  bool has_holes_ = false;
};

}  // namespace isoextract::extract

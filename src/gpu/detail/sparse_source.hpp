// Sparse samples on the device, in an atlas of leaves (8x8x8 samples). Only leaves that the sites need are uploaded.
// Each leaf is uploaded once if the atlas can hold all leaves needed at the same time; sites sorted by position need
// few. A box of 8x8x8 samples without a leaf is stored as one constant.
#pragma once

#include <deque>
#include <map>
#include <utility>

#include "extract/sparse_sites.hpp"
#include "gpu/detail/field_source.hpp"

namespace isoextract::gpu {

class SparseSource final : public FieldSource {
 public:
  // Makes a source. Context, samples and sites must outlive the source. Fails with ErrorCode::usage if options.bytes is
  // too small, and as GlContext::check() does.
  [[nodiscard]] static Result<SparseSource> make(const gl::GlContext& context, const field::SparseSamples& samples,
                                                 const extract::SparseSites& sites, const SourceOptions& options);

  [[nodiscard]] Result<std::span<const std::uint32_t>> advance() override;
  void bind(const gl::CountAndCapture& pass, std::span<const std::uint32_t> sites) override;
  [[nodiscard]] UploadFigures uploads() const override;

 private:
  SparseSource(const gl::GlContext& context, const field::SparseSamples& samples, const extract::SparseSites& sites,
               const SourceOptions& options);

  // Calls f(n, lowest sample) for each box of 8x8x8 samples that the site's cells need; n is the number of the box in
  // the 3x3x3 boxes around the site.
  template <class F>
  void for_each_place(std::uint32_t site, const F& f) const;
  [[nodiscard]] bool make_resident(std::uint32_t site);
  [[nodiscard]] std::int32_t take_slot();
  void upload(std::int32_t block, std::int32_t slot);
  [[nodiscard]] std::int32_t constant_at(const glm::ivec3& place);

  const gl::GlContext* context_;
  const field::SparseSamples* samples_;
  const extract::SparseSites* sites_;
  SourceOptions options_;
  SampleFormat format_;
  glm::ivec3 slots_{0};  // number of slots along each axis of the atlas texture
  gl::GlTexture atlas_;
  gl::GlBuffer neighbor_buffer_, constant_buffer_;
  gl::GlTexture neighbor_texture_, constant_texture_;

  std::vector<std::uint32_t> order_;                 // all sites in drawing order
  std::size_t next_ = 0;                             // index into order_
  std::int32_t round_ = 0;                           // number of calls of advance()
  std::vector<std::int32_t> slot_of_;                // by block; -1 if it is not resident
  std::vector<std::int32_t> block_in_;               // by slot
  std::vector<std::int32_t> used_in_;                // by slot: the last round that needed it
  std::deque<std::int32_t> by_age_;                  // slots, first uploaded first
  std::map<std::uint64_t, std::int32_t> constants_;  // bits of a constant to its number
  std::vector<glm::uvec2> constant_words_;
  UploadFigures uploads_;
};

}  // namespace isoextract::gpu

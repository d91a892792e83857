// Dense samples on the device: a toroidal window (toroidal_window.hpp) that slides through the field in z, over columns
// of bricks where a whole slice is too large. Only bricks that the surface's sites need are uploaded; within a column
// every sample at most once, and samples that two columns share once for each. Where samples stay on the device for the
// next extraction (resident_samples.hpp) and all of them fit, only bricks that are not there as they are now.
#pragma once

#include "extract/extractor.hpp"
#include "gpu/detail/field_source.hpp"
#include "gpu/detail/resident_samples.hpp"
#include "gpu/detail/toroidal_window.hpp"

namespace isoextract::gpu {

class DenseSource final : public FieldSource {
 public:
  // `region` holds the samples that cells may touch, and `sites` are the lowest samples of bricks of 8 x 8 x 8 of those
  // cells, from region.min on; by rising z, then y, then x. Context, samples and sites must outlive the source. What is
  // taken on the device reaches no farther than the sites do, but for what stays there. Fails with ErrorCode::usage
  // where the bytes are too few.
  [[nodiscard]] static Result<DenseSource> make(const gl::GlContext& context, const field::DenseSamples& samples,
                                                std::span<const glm::ivec3> sites, const field::IndexBox& region,
                                                const SourceOptions& options);

  [[nodiscard]] Result<std::span<const std::uint32_t>> advance() override;
  void bind(const gl::CellPass& pass, std::span<const std::uint32_t> sites) override;
  [[nodiscard]] UploadFigures uploads() const override;

 private:
  DenseSource(const gl::GlContext& context, const field::DenseSamples& samples, std::span<const glm::ivec3> sites,
              const field::IndexBox& region, const SourceOptions& options);
  [[nodiscard]] Result<void> choose_window();
  [[nodiscard]] Result<void> use_resident();
  void begin_column();
  [[nodiscard]] field::IndexBox needed_samples(const glm::ivec3& site) const;
  [[nodiscard]] field::IndexBox brick_box(const glm::ivec3& brick) const;
  void leave_out_resident(std::vector<BrickHash>& hashes);
  void upload(const field::IndexBox& entered);
  void upload_pieces(const field::IndexBox& box);
  [[nodiscard]] const gl::GlTexture& texture() const {
    return options_.resident != nullptr ? options_.resident->texture() : texture_;
  }

  const gl::GlContext* context_;
  const field::DenseSamples* samples_;
  std::span<const glm::ivec3> sites_;
  field::IndexBox region_;
  SourceOptions options_;
  SampleFormat format_;
  int apron_;                // samples beyond a site's cells, on each side
  field::IndexBox box_;      // samples that cells of sites touch
  field::IndexBox reach_;    // with those around them
  glm::ivec3 origin_;        // bricks of samples begin there, so that a site needs two along each axis at most
  glm::ivec3 base_;          // window coordinates count from there
  glm::ivec2 column_cells_;  // of a column, in x and y
  ToroidalWindow window_;
  gl::GlTexture texture_;  // where nothing stays on the device

  glm::ivec2 columns_{0};
  int column_ = -1;                          // in x, then y
  std::vector<std::uint32_t> column_sites_;  // by rising z
  std::size_t next_ = 0;                     // into column_sites_
  field::IndexBox column_reach_;             // samples of the column
  glm::ivec3 first_brick_{0};                // of `needed_`
  glm::ivec3 bricks_{0};                     // of `needed_`, along each axis
  std::vector<std::uint8_t> needed_;         // by brick of the column
  UploadFigures uploads_;
};

}  // namespace isoextract::gpu

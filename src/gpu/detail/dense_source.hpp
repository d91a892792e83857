// Dense samples on the device, in a toroidal window (toroidal_window.hpp) that slides through the field in z. If a
// whole slice is too large, the window slides over one column of bricks after the other. Only bricks that the sites
// need are uploaded. Within a column every sample is uploaded at most once; samples that two columns share are uploaded
// once for each.
//
// If samples stay on the device for the next extraction (resident_samples.hpp) and all of them fit, only bricks that
// are missing or changed are uploaded.
#pragma once

#include "extract/extractor.hpp"
#include "gpu/detail/field_source.hpp"
#include "gpu/detail/resident_samples.hpp"
#include "gpu/detail/toroidal_window.hpp"

namespace isoextract::gpu {

class DenseSource final : public FieldSource {
 public:
  // Makes a source. `region` is the box of samples that cells may touch. `sites` are the lowest samples of bricks of
  // 8x8x8 cells, counted from region.min and sorted by z, then y, then x. Context, samples and sites must outlive the
  // source. Allocates only as much on the device as the sites span, except for resident samples. Fails with
  // ErrorCode::usage if options.bytes is too small.
  [[nodiscard]] static Result<DenseSource> make(const gl::GlContext& context, const field::DenseSamples& samples,
                                                std::span<const glm::ivec3> sites, const field::IndexBox& region,
                                                const SourceOptions& options);

  [[nodiscard]] Result<std::span<const std::uint32_t>> advance() override;
  void bind(const gl::CountAndCapture& pass, std::span<const std::uint32_t> sites) override;
  [[nodiscard]] UploadFigures uploads() const override;

 private:
  DenseSource(const gl::GlContext& context, const field::DenseSamples& samples, std::span<const glm::ivec3> sites,
              const field::IndexBox& region, const SourceOptions& options);
  [[nodiscard]] Result<void> choose_window();
  [[nodiscard]] Result<void> use_resident();
  void begin_column();
  [[nodiscard]] field::IndexBox needed_samples(const glm::ivec3& site) const;
  [[nodiscard]] field::IndexBox brick_box(const glm::ivec3& brick) const;
  void skip_resident_bricks(std::vector<BrickHash>& hashes);
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
  int apron_;                // number of samples needed beyond a site's cells, on each side
  field::IndexBox box_;      // box of the samples that cells of sites touch
  field::IndexBox reach_;    // box_ with the apron
  glm::ivec3 origin_;        // bricks of samples are counted from here, so that a site needs at most two along each
                             // axis
  glm::ivec3 base_;          // window coordinates are relative to this sample
  glm::ivec2 column_cells_;  // size of a column in x and y
  ToroidalWindow window_;
  gl::GlTexture texture_;  // used if no samples stay on the device

  glm::ivec2 columns_{0};
  int column_ = -1;                          // current column, counted along x, then y
  std::vector<std::uint32_t> column_sites_;  // sites of the column, by rising z
  std::size_t next_ = 0;                     // index into column_sites_
  field::IndexBox column_reach_;             // samples that the column may need
  glm::ivec3 first_brick_{0};                // the brick of needed_[0]
  glm::ivec3 bricks_{0};                     // size of `needed_` along each axis
  std::vector<std::uint8_t> needed_;         // for each brick of the column: 1 if a site needs it
  UploadFigures uploads_;
};

}  // namespace isoextract::gpu

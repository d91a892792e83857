// How the samples of a field get to the device, in the order in which sites are drawn.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/byte_size.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "gl/gl_object.hpp"
#include "gl/gl_program.hpp"
#include "gpu/detail/sample_format.hpp"

namespace isoextract::gpu {

class ResidentSamples;

struct SourceOptions {
  bool gradients = false;               // samples around a vertex are read as well
  std::uint64_t bytes = 0;              // what samples may take on the device
  int max_texture_size = 0;             // of the device, in 3D
  ResidentSamples* resident = nullptr;  // what stays on the device for the next extraction, where anything does
  const Context* host = nullptr;        // what is known of it is reserved there
};

struct UploadFigures {
  std::uint64_t bytes = 0;         // of samples
  std::uint64_t samples = 0;       // each counted as often as it was uploaded
  std::uint64_t left_out = 0;      // samples that no crossed brick needs, less what was uploaded more than once
  std::uint64_t samples_kept = 0;  // needed, and on the device since an extraction before
  std::uint64_t bricks = 0;        // that were uploaded, of 8 x 8 x 8 samples: counted where some may be kept
  std::uint64_t bricks_kept = 0;
  StageTime time;
};

class FieldSource {
 public:
  virtual ~FieldSource() = default;

  // Uploads what the next sites need and names them by their numbers; none when all were named. Each site is named
  // once.
  [[nodiscard]] virtual Result<std::span<const std::uint32_t>> advance() = 0;

  // Before drawing some of the sites that advance() named last, given by their numbers.
  virtual void bind(const gl::CellPass& pass, std::span<const std::uint32_t> sites) = 0;

  [[nodiscard]] virtual UploadFigures uploads() const = 0;
};

// What sources share. A texture of samples as bits, nothing in it yet; fails as GlContext::check() does.
[[nodiscard]] Result<gl::GlTexture> make_sample_texture(const gl::GlContext& context, field::SampleType type,
                                                        const glm::ivec3& size);
// ErrorCode::usage.
[[nodiscard]] tl::unexpected<Error> too_few_bytes(std::uint64_t bytes, std::uint64_t least);

}  // namespace isoextract::gpu

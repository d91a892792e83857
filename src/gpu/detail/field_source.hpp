// Uploads the samples of a field to the device, in the order in which sites are drawn.
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
  bool gradients = false;               // also needs the samples around each vertex, for gradients
  std::uint64_t bytes = 0;              // limit for samples on the device
  int max_texture_size = 0;             // limit of the device for 3D textures
  ResidentSamples* resident = nullptr;  // samples that stay on the device for the next extraction; null if none do
  const Context* host = nullptr;        // memory for the hashes of resident samples is reserved here
};

struct UploadFigures {
  std::uint64_t bytes = 0;         // size of the uploaded samples
  std::uint64_t samples = 0;       // counts repeated uploads
  std::uint64_t left_out = 0;      // samples that no crossed brick needs, minus repeated uploads
  std::uint64_t samples_kept = 0;  // needed samples that were still on the device
  std::uint64_t bricks = 0;        // uploaded bricks of 8x8x8 samples; counted only if samples are resident
  std::uint64_t bricks_kept = 0;
  StageTime time;
};

class FieldSource {
 public:
  virtual ~FieldSource() = default;

  // Uploads the samples that the next sites need, and returns the numbers of these sites. Returns an empty span after
  // the last site. Each site is returned once.
  [[nodiscard]] virtual Result<std::span<const std::uint32_t>> advance() = 0;

  // Binds textures and uniforms before a draw. `sites` are some of the numbers that advance() returned last.
  virtual void bind(const gl::CountAndCapture& pass, std::span<const std::uint32_t> sites) = 0;

  [[nodiscard]] virtual UploadFigures uploads() const = 0;
};

// Returns an empty texture for the bits of samples. Fails as GlContext::check() does.
[[nodiscard]] Result<gl::GlTexture> make_sample_texture(const gl::GlContext& context, field::SampleType type,
                                                        const glm::ivec3& size);
// Returns the error (ErrorCode::usage) that `bytes` are too few and `least` are needed.
[[nodiscard]] tl::unexpected<Error> too_little_memory(std::uint64_t bytes, std::uint64_t least);

}  // namespace isoextract::gpu

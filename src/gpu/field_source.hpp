// How the samples of a field get to the device, in the order in which sites are drawn.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "gpu/gl_program.hpp"

namespace isoextract {

struct UploadFigures {
  std::uint64_t bytes = 0;     // of samples
  std::uint64_t samples = 0;   // each counted as often as it was uploaded
  std::uint64_t left_out = 0;  // samples that no crossed brick needs, less what was uploaded more than once
  StageTime time;
};

class FieldSource {
 public:
  virtual ~FieldSource() = default;

  // Uploads what the next sites need and names them by their numbers; none when all were named. Each site is named
  // once.
  [[nodiscard]] virtual Result<std::span<const std::uint32_t>> advance() = 0;

  // Before drawing some of the sites that advance() named last, given by their numbers.
  virtual void bind(const CellProgram& program, std::span<const std::uint32_t> sites) = 0;

  [[nodiscard]] virtual UploadFigures uploads() const = 0;
};

}  // namespace isoextract

#include "simulate/terrain.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "simulate/detail/perlin_noise.hpp"

namespace isoextract::simulate {
namespace {

constexpr double kHillsAcross = 3.5;  // hills of the first octave along the longer side
constexpr double kHills = 0.42;       // amplitude of the noise, relative to the slope into the basin

Result<void> check_terrain(const TerrainOptions& options) {
  if (std::min(options.size.x, options.size.y) < 2 || std::max(options.size.x, options.size.y) > kMaxGridSize) {
    return fail(ErrorCode::usage,
                fmt::format("the size of the terrain: expected 2 to {} cells along x and y, found {} x {}",
                            kMaxGridSize, options.size.x, options.size.y));
  }
  if (!(std::isfinite(options.relief) && options.relief >= 0)) {
    return fail(ErrorCode::usage,
                fmt::format("the relief of the terrain: expected 0 or more cells, found {}", options.relief));
  }
  if (options.octaves < 1 || options.octaves > 16) {
    return fail(ErrorCode::usage,
                fmt::format("the octaves of the terrain: expected 1 to 16, found {}", options.octaves));
  }
  return {};
}

}  // namespace

Result<std::shared_ptr<ReservedBuffer<double>>> make_terrain(const TerrainOptions& options, const Context& context) {
  TRY(check_terrain(options));
  const glm::ivec2 size = options.size;
  auto made = make_reserved_buffer<double>(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y), context,
                                           "the terrain");
  if (!made) return made;
  Buffer<double>& heights = (*made)->values;
  const FractalNoise noise(options.seed, options.octaves);
  const double scale = kHillsAcross / std::max(size.x, size.y);
  for_each_index(size.y, [&](int y) {
    for (int x = 0; x < size.x; ++x) {
      const glm::dvec2 middle = glm::dvec2(x, y) + 0.5;
      // Slopes down to the basin from all sides, steeper further out, with hills on top.
      const glm::dvec2 away = (middle / glm::dvec2(size) - kBasin) / kBasin;
      const double slope = glm::dot(away, away);
      heights[static_cast<std::size_t>(x) + static_cast<std::size_t>(size.x) * static_cast<std::size_t>(y)] =
          slope + kHills * noise(glm::dvec3(scale * middle, 0.0));
    }
  });
  const auto [least, most] = std::minmax_element(heights.begin(), heights.end());
  const double low = *least;
  const double range = *most - low;
  for (double& height : heights.span())
    height = kMinLandHeight + (range > 0 ? options.relief * ((height - low) / range) : 0);
  return made;
}

}  // namespace isoextract::simulate

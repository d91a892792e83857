#include "render/detail/volume_bricks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/parallel.hpp"

namespace isoextract::render::detail {
namespace {

class PositionRange {
 public:
  void add(float position) {
    // NaN fails both comparisons.
    if (position < low_) low_ = position;
    if (position > high_) high_ = position;
  }
  [[nodiscard]] bool seen(const TransferFunction& transfer) const {
    return low_ <= high_ && transfer.is_visible_between(low_, high_);
  }

 private:
  float low_ = std::numeric_limits<float>::infinity();
  float high_ = -low_;
};

// Returns the bricks that contain a sample of a stored block.
std::vector<glm::ivec3> brick_origins(const field::SparseSamples& sparse) {
  constexpr int kSize = field::SparseBlock::kSize;
  std::vector<glm::ivec3> origins;
  const auto before = [](const glm::ivec3& a, const glm::ivec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  const auto add_around = [&](const glm::ivec3& place) {
    for (int n = 0; n < 8; ++n) origins.push_back(place - kSize * glm::ivec3(n & 1, n >> 1 & 1, n >> 2));
  };
  for (const field::SparseBlock& block : sparse.blocks) add_around(block.origin);
  std::ranges::sort(origins, before);
  origins.erase(std::unique(origins.begin(), origins.end()), origins.end());
  return origins;
}

}  // namespace

Result<VolumeBricks> VolumeBricks::measure(const VolumeSamples& samples, const Context& context) {
  VolumeBricks bricks(samples);
  const field::DenseSamples* dense = samples.dense();
  std::uint64_t bytes = 0;
  if (dense != nullptr) {
    bricks.dims_ = (glm::i64vec3(dense->dims) - std::int64_t{1} + std::int64_t{kCells - 1}) / std::int64_t{kCells};
    bytes = static_cast<std::uint64_t>(bricks.dims_.x * bricks.dims_.y * bricks.dims_.z);
  } else {
    // Eight candidates per block before duplicates are removed, and the index of the remaining ones.
    bytes = samples.sparse().blocks.size() * 8 * (sizeof(glm::ivec3) + 2 * (sizeof(glm::ivec3) + sizeof(std::int32_t)));
  }
  bricks.memory_ = TRY(context.reserve(bytes, samples.field().source + ": bricks"));
  if (dense == nullptr) {
    bricks.origins_ = brick_origins(samples.sparse());
    bricks.index_ = field::OriginIndex(bricks.origins_.size());
    for (std::size_t n = 0; n < bricks.origins_.size(); ++n) {
      bricks.index_.insert(bricks.origins_[n], static_cast<std::int32_t>(n));
    }
  }
  const std::size_t count = dense != nullptr ? static_cast<std::size_t>(bytes) : bricks.origins_.size();
  bricks.seen_.resize(count);
  context.progress().begin("measuring bricks", count);
  field::visit_sample_type(samples.field().type(), [&]<class T>(std::type_identity<T>) {
    for_each_range(count, 64, [&](std::size_t first, std::size_t last) {
      if (context.cancelled()) return;
      SampleReader<T> reader(samples);
      for (std::size_t n = first; n != last; ++n) {
        glm::ivec3 origin;
        glm::ivec3 end;  // the brick's last sample
        if (dense != nullptr) {
          const auto at = static_cast<std::int64_t>(n);
          const glm::i64vec3 dims = bricks.dims_;
          origin = kCells * glm::ivec3(at % dims.x, at / dims.x % dims.y, at / (dims.x * dims.y));
          end = glm::min(origin + kCells, dense->dims - 1);
        } else {
          origin = bricks.origins_[n];
          end = origin + kCells;
        }
        PositionRange positions;
        for (int k = origin.z; k <= end.z; ++k) {
          for (int j = origin.y; j <= end.y; ++j) {
            for (int i = origin.x; i <= end.x; ++i) positions.add(reader({i, j, k}));
          }
        }
        bricks.seen_[n] = positions.seen(samples.transfer()) ? 1 : 0;
      }
      context.progress().advance(last - first);
    });
  });
  TRY(context.check());
  return bricks;
}

bool VolumeBricks::is_visible(const glm::ivec3& brick) const {
  if (samples_->dense() != nullptr) {
    return seen_[static_cast<std::size_t>(brick.x + dims_.x * (brick.y + dims_.y * brick.z))] != 0;
  }
  const glm::ivec3 origin = brick * kCells;
  if (const std::int32_t number = index_.find(origin); number >= 0) return seen_[static_cast<std::size_t>(number)] != 0;
  PositionRange positions;
  for (const std::int32_t place : samples_->lookup().group(origin)) {
    positions.add(samples_->position(samples_->lookup().constant_of(place)));
  }
  return positions.seen(samples_->transfer());
}

std::uint64_t VolumeBricks::count_invisible() const {
  return static_cast<std::uint64_t>(std::ranges::count(seen_, std::uint8_t{0}));
}

}  // namespace isoextract::render::detail

#include "render/detail/volume_nodes.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/parallel.hpp"

namespace isoextract::render::detail {

class VolumeNodes::Lister {
 public:
  Lister(const VolumeSamples& samples, const VolumeBricks* bricks, const glm::ivec3& first, const glm::ivec3& last,
         const Context& context)
      : samples_(samples),
        bricks_(bricks),
        first_brick_(first >> 3),
        last_brick_(last >> 3),
        context_(context),
        source_(samples.field().source) {
    list_.first_ = first >> 7;
    list_.dims_ = (last >> 7) - list_.first_ + 1;
  }

  Result<VolumeNodes> list() {
    const glm::u64vec3 dims(list_.dims_);
    // Each axis has at most 2^23 nodes. If their product may overflow, uses a number that no memory budget allows.
    const std::uint64_t nodes = dims.x * dims.y > std::numeric_limits<std::int32_t>::max()
                                    ? std::numeric_limits<std::uint64_t>::max() / 64
                                    : dims.x * dims.y * dims.z;
    TRY(take(nodes * sizeof(std::int32_t), "brick indices"));
    list_.nodes_.assign(nodes, kInvisible);
    find_nodes();
    std::int32_t count = 0;
    for (std::int32_t& node : list_.nodes_) {
      if (node == kOwn) node = count++;
      // A temporary number that no node has.
      else if (node == kConstant)
        node = kConstantNode;
    }
    const std::uint64_t bricks = std::max(count, 1) * std::uint64_t{kBricks};
    if (bricks > std::numeric_limits<std::int32_t>::max()) {
      return fail(ErrorCode::unavailable,
                  fmt::format("{}: expected at most {} bricks for a GPU, found {}", source_,
                              std::numeric_limits<std::int32_t>::max(), bricks),
                  {Remedy::use, Setting::cpu_backend});
    }
    TRY(take(bricks * sizeof(std::int32_t), "brick indices"));
    list_.bricks_.assign(bricks, kInvisible);
    find_bricks();
    TRY(context_.check());
    const auto own = static_cast<std::uint64_t>(std::ranges::count(list_.bricks_, kOwn));
    TRY(take(own * sizeof(glm::ivec3), "bricks"));
    list_.slots_.reserve(own);
    number_slots();
    return std::move(list_);
  }

 private:
  static constexpr std::int32_t kConstantNode = std::numeric_limits<std::int32_t>::min();

  [[nodiscard]] Result<void> take(std::uint64_t bytes, const char* what) {
    auto memory = TRY(context_.reserve(bytes, fmt::format("{}: {}", source_, what)));
    list_.memory_.take(std::move(memory));
    return {};
  }

  [[nodiscard]] glm::ivec3 node_at(std::size_t n) const {
    const auto at = static_cast<std::int64_t>(n);
    const glm::i64vec3 dims(list_.dims_);
    return list_.first_ + glm::ivec3(at % dims.x, at / dims.x % dims.y, at / (dims.x * dims.y));
  }
  [[nodiscard]] static glm::ivec3 brick_in_node(std::size_t b) { return glm::ivec3(b >> 8, b >> 4 & 15, b & 15); }

  // Classifies a cube of cells whose samples all have the constant values of the places around its corners: kInvisible,
  // kConstant if there is one value, otherwise kOwn.
  template <class Place>
  [[nodiscard]] std::int32_t kind_of_constants(const Place& place) const {
    float low = std::numeric_limits<float>::infinity();
    float high = -low;
    bool same = true;
    const float first = samples_.position(samples_.lookup().constant_of(place(0)));
    for (int n = 0; n < 8; ++n) {
      const float position = samples_.position(samples_.lookup().constant_of(place(n)));
      same = same && std::bit_cast<std::uint32_t>(position) == std::bit_cast<std::uint32_t>(first);
      if (position < low) low = position;
      if (position > high) high = position;
    }
    if (bricks_ != nullptr && !(low <= high && samples_.transfer().is_visible_between(low, high))) return kInvisible;
    return same ? kConstant : kOwn;
  }

  // Classifies each node; kOwn means that its bricks need to be classified one by one.
  void find_nodes() {
    if (samples_.dense() != nullptr) {
      std::ranges::fill(list_.nodes_, kOwn);
      return;
    }
    for_each_index(list_.nodes_.size(), [&](std::size_t n) {
      // Blocks and small tiles are in nodes of the lookup, which have the same size. The last samples of a node belong
      // to the next one.
      const glm::ivec3 origin = kCells * node_at(n);
      list_.nodes_[n] = kInvisible;
      std::int32_t places[8];
      for (int c = 0; c < 8; ++c) {
        const glm::ivec3 at = origin + kCells * glm::ivec3(c & 1, c >> 1 & 1, c >> 2);
        if (lookup_nodes_.find(at) >= 0) {
          list_.nodes_[n] = kOwn;
          return;
        }
        places[c] = samples_.lookup().place(at);
      }
      list_.nodes_[n] = kind_of_constants([&](int c) { return places[c]; });
    });
  }

  void find_bricks() {
    for_each_index(list_.nodes_.size(), [&](std::size_t n) {
      const std::int32_t node = list_.nodes_[n];
      if (node < 0 || context_.cancelled()) return;
      const glm::ivec3 first = kSide * node_at(n);
      for (std::size_t b = 0; b < kBricks; ++b) {
        const glm::ivec3 brick = first + brick_in_node(b);
        if (glm::any(glm::lessThan(brick, first_brick_)) || glm::any(glm::greaterThan(brick, last_brick_))) continue;
        list_.bricks_[kBricks * static_cast<std::size_t>(node) + b] = kind_of(brick);
      }
    });
  }

  [[nodiscard]] std::int32_t kind_of(const glm::ivec3& brick) const {
    if (samples_.dense() == nullptr) {
      const auto group = samples_.lookup().group(VolumeBricks::kCells * brick);
      if (std::ranges::none_of(group, [](std::int32_t place) { return place >= 0; })) {
        return kind_of_constants([&](int n) { return group[static_cast<std::size_t>(n)]; });
      }
    }
    return bricks_ == nullptr || bricks_->is_visible(brick) ? kOwn : kInvisible;
  }

  void number_slots() {
    for (std::size_t n = 0; n < list_.nodes_.size(); ++n) {
      std::int32_t& node = list_.nodes_[n];
      const glm::ivec3 first = kSide * node_at(n);
      if (node == kConstantNode) node = ~(shared_slot(VolumeBricks::kCells * first) + 1);
      if (node < 0) continue;
      for (std::size_t b = 0; b < kBricks; ++b) {
        std::int32_t& slot = list_.bricks_[kBricks * static_cast<std::size_t>(node) + b];
        const glm::ivec3 origin = VolumeBricks::kCells * (first + brick_in_node(b));
        if (slot == kOwn) {
          slot = new_slot(origin);
        } else if (slot == kConstant) {
          slot = shared_slot(origin);
        }
      }
    }
  }

  std::int32_t new_slot(const glm::ivec3& origin) {
    list_.slots_.push_back(origin);
    return static_cast<std::int32_t>(list_.slots_.size() - 1);
  }
  std::int32_t shared_slot(const glm::ivec3& origin) {
    const auto bits = std::bit_cast<std::uint32_t>(samples_.position(samples_.lookup().constant(origin)));
    const auto [found, fresh] = constant_slots_.try_emplace(bits, 0);
    if (fresh) found->second = new_slot(origin);
    return found->second;
  }

  const VolumeSamples& samples_;
  const VolumeBricks* bricks_;
  glm::ivec3 first_brick_;
  glm::ivec3 last_brick_;
  const Context& context_;
  const std::string& source_;
  field::OriginIndex lookup_nodes_ = index_of_nodes(samples_);
  std::map<std::uint32_t, std::int32_t> constant_slots_;
  VolumeNodes list_;

  [[nodiscard]] static field::OriginIndex index_of_nodes(const VolumeSamples& samples) {
    if (samples.dense() != nullptr) return {};
    const auto& nodes = samples.lookup().nodes();
    field::OriginIndex index(nodes.size());
    for (std::size_t n = 0; n < nodes.size(); ++n) index.insert(nodes[n].origin, static_cast<std::int32_t>(n));
    return index;
  }
};

Result<VolumeNodes> VolumeNodes::list(const VolumeSamples& samples, const VolumeBricks* bricks, const glm::ivec3& first,
                                      const glm::ivec3& last, const Context& context) {
  return Lister(samples, bricks, first, last, context).list();
}

}  // namespace isoextract::render::detail

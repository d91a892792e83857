#include "mesh/detail/sums_of_parts.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/packed_values.hpp"
#include "base/parallel.hpp"
#include "mesh/detail/rank_turns.hpp"

namespace isoextract::mesh {
namespace {

// Appends the ends of the ranges into which reduce_ranges() splits [begin, end).
void add_range_ends(std::uint64_t begin, std::uint64_t end, std::vector<std::uint64_t>& ends) {
  if (end - begin <= kSizeGrain) {
    ends.push_back(end);
    return;
  }
  const std::uint64_t middle = begin + (end - begin) / 2;
  add_range_ends(begin, middle, ends);
  add_range_ends(middle, end, ends);
}

// Joins the sums of these ranges as reduce_ranges() does.
MeshSize join_ranges(std::uint64_t begin, std::uint64_t end, std::span<const MeshSize>& sums) {
  if (end - begin <= kSizeGrain) {
    const MeshSize sum = sums.front();
    sums = sums.subspan(1);
    return sum;
  }
  const std::uint64_t middle = begin + (end - begin) / 2;
  const MeshSize earlier = join_ranges(begin, middle, sums);
  return joined(earlier, join_ranges(middle, end, sums));
}

// Triangles that one thread sums: a range of reduce_ranges() or a chunk, or a piece of one that began or ends in
// another part. `begin` and `end` are numbers in the part.
struct Piece {
  std::size_t begin = 0;
  std::size_t end = 0;
  bool is_last = false;  // of its range or chunk
};

// Splits the triangles of a part, without those before number `head` of the mesh. next_end(t) returns the end of the
// range that contains triangle t.
template <class NextEnd>
std::vector<Piece> split(const LocalPart& part, std::uint64_t head, const NextEnd& next_end) {
  std::vector<Piece> pieces;
  const std::uint64_t first = part.first_triangle;
  const std::uint64_t count = part.triangles.size();
  for (std::uint64_t begin = std::clamp(head, first, first + count) - first; begin < count;) {
    const std::uint64_t range_end = next_end(first + begin) - first;
    const std::uint64_t end = std::min(range_end, count);
    pieces.push_back({begin, end, end == range_end});
    begin = end;
  }
  return pieces;
}

std::uint64_t chunk_end(std::uint64_t triangle) { return (triangle / kComponentChunk + 1) * kComponentChunk; }

}  // namespace

SumsOfParts::SumsOfParts(std::uint64_t triangles, bool is_shared, std::string what, const Context& context)
    : triangles_(triangles), is_shared_(is_shared), what_(std::move(what)), context_(context) {
  add_range_ends(0, triangles, range_ends_);
}

Result<void> SumsOfParts::take_memory(std::uint64_t bytes) {
  memory_.take(TRY(context_.reserve(bytes, what_)));
  return {};
}

Result<void> SumsOfParts::add(const LocalPart& part, const SumSpace& space, const glm::dvec3& origin,
                              std::vector<ComponentFacts>& facts) {
  if (part.triangles.empty()) return {};
  if (is_shared_) {
    if (numbers_.end == 0) {
      begin_numbers(part.first_triangle);
      TRY(take_memory((std::max(numbers_.range_head, numbers_.chunk_head) - numbers_.first) * sizeof(HeadTriangle)));
    }
    numbers_.end = part.first_triangle + part.triangles.size();
    keep_head(part);
  }
  const std::size_t known = chunks_.size();
  add_ranges(part, space);
  add_chunks(part, space, origin, facts);
  return take_memory((chunks_.size() - known) * sizeof(ComponentSum));
}

void SumsOfParts::begin_numbers(std::uint64_t first) {
  numbers_ = {first, first, first, first};
  const auto range = std::ranges::upper_bound(range_ends_, first);
  const bool begins_range = range == range_ends_.begin() ? first == 0 : *std::prev(range) == first;
  if (!begins_range) numbers_.range_head = *range;
  if (first % kComponentChunk != 0) numbers_.chunk_head = chunk_end(first);
}

void SumsOfParts::keep_head(const LocalPart& part) {
  const std::uint64_t end = std::max(numbers_.range_head, numbers_.chunk_head);
  for (std::size_t t = 0; t < part.triangles.size() && part.first_triangle + t < end; ++t) {
    const glm::uvec3 corners = part.triangles[t];
    HeadTriangle& kept = head_.emplace_back();
    for (int c = 0; c < 3; ++c) kept.corners[static_cast<std::size_t>(c)] = part.positions[corners[c]];
    if (corners.y == corners.x) kept.same.y = 0;
    if (corners.z == corners.y) kept.same.z = kept.same.y;
    if (corners.z == corners.x) kept.same.z = 0;
    kept.component = part.components[corners.x];
  }
}

void SumsOfParts::add_ranges(const LocalPart& part, const SumSpace& space) {
  const auto ranges =
      split(part, numbers_.range_head, [&](std::uint64_t t) { return *std::ranges::upper_bound(range_ends_, t); });
  std::vector<MeshSize> sizes(ranges.size());
  if (!sizes.empty()) sizes.front() = std::exchange(open_range_, {});
  for_each_index(ranges.size(), [&](std::size_t r) {
    const auto triangles = part.triangles.subspan(ranges[r].begin, ranges[r].end - ranges[r].begin);
    sizes[r] = with_sizes(sizes[r], part.positions, triangles, space.apex);
  });
  for (std::size_t r = 0; r < ranges.size(); ++r) {
    if (ranges[r].is_last)
      ranges_.push_back(sizes[r]);
    else
      open_range_ = sizes[r];
  }
}

void SumsOfParts::add_chunks(const LocalPart& part, const SumSpace& space, const glm::dvec3& origin,
                             std::vector<ComponentFacts>& facts) {
  const auto chunks = split(part, numbers_.chunk_head, chunk_end);
  std::vector<std::vector<ComponentSum>> sums(chunks.size());
  if (!sums.empty()) sums.front() = std::exchange(open_chunk_, {});
  for_each_index(chunks.size(), [&](std::size_t c) {
    const auto triangles = part.triangles.subspan(chunks[c].begin, chunks[c].end - chunks[c].begin);
    add_triangles(sums[c], part.positions, triangles, space,
                  [&](std::uint32_t vertex) { return part.components[vertex]; });
  });
  for (std::size_t c = 0; c < chunks.size(); ++c) {
    if (!chunks[c].is_last) {
      open_chunk_ = std::move(sums[c]);
    } else if (is_shared_) {
      chunks_.insert(chunks_.end(), sums[c].begin(), sums[c].end());
      chunk_counts_.push_back(static_cast<std::uint32_t>(sums[c].size()));
    } else {
      add_chunk(facts, sums[c], origin);
    }
  }
}

std::string SumsOfParts::packed() const {
  return Packer()
      .put(numbers_)
      .put(open_range_)
      .put(bytes_of(head_))
      .put(bytes_of(ranges_))
      .put(bytes_of(open_chunk_))
      .put(bytes_of(chunks_))
      .put(bytes_of(chunk_counts_))
      .take();
}

Result<void> SumsOfParts::append(std::string_view packed, const SumSpace& space, const glm::dvec3& origin,
                                 std::vector<ComponentFacts>& facts) {
  const auto memory = TRY(context_.reserve(3 * packed.size(), what_));
  Unpacker from(packed);
  const auto numbers = from.get<Numbers>();
  if (numbers.end == 0) return {};  // a rank without triangles
  const auto open_range = from.get<MeshSize>();
  const auto head = values_of<HeadTriangle>(from.get<std::string>());
  const auto ranges = values_of<MeshSize>(from.get<std::string>());
  auto open_chunk = values_of<ComponentSum>(from.get<std::string>());
  const auto chunks = values_of<ComponentSum>(from.get<std::string>());
  const auto chunk_counts = values_of<std::uint32_t>(from.get<std::string>());

  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  for (const HeadTriangle& one : head) {
    triangles.push_back(static_cast<unsigned>(positions.size()) + one.same);
    positions.insert(positions.end(), one.corners.begin(), one.corners.end());
  }
  const auto before = [&](std::uint64_t end) {
    return std::span<const glm::uvec3>(triangles).first(
        static_cast<std::size_t>(std::min(end, numbers.end) - numbers.first));
  };

  open_range_ = with_sizes(open_range_, positions, before(numbers.range_head), space.apex);
  if (numbers.end >= numbers.range_head) {
    if (numbers.range_head > numbers.first) ranges_.push_back(open_range_);
    ranges_.insert(ranges_.end(), ranges.begin(), ranges.end());
    open_range_ = open_range;
  }

  add_triangles(open_chunk_, positions, before(numbers.chunk_head), space,
                [&](std::uint32_t vertex) { return head[vertex / 3].component; });
  if (numbers.end >= numbers.chunk_head) {
    if (numbers.chunk_head > numbers.first) add_chunk(facts, open_chunk_, origin);
    std::span<const ComponentSum> rest(chunks);
    for (const std::uint32_t count : chunk_counts) {
      add_chunk(facts, rest.first(count), origin);
      rest = rest.subspan(count);
    }
    open_chunk_ = std::move(open_chunk);
  }
  return {};
}

MeshSize SumsOfParts::finish(const glm::dvec3& origin, std::vector<ComponentFacts>& facts) {
  if (!open_chunk_.empty()) add_chunk(facts, open_chunk_, origin);
  std::span<const MeshSize> ranges = ranges_;
  return triangles_ > 0 ? join_ranges(0, triangles_, ranges) : MeshSize();
}

}  // namespace isoextract::mesh

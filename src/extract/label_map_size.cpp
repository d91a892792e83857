#include "extract/label_map_size.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <string>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "base/parallel.hpp"
#include "extract/detail/corner_words.hpp"
#include "extract/detail/face_rectangles.hpp"
#include "extract/detail/label_bits.hpp"
#include "extract/detail/label_chunks.hpp"
#include "extract/detail/label_parts.hpp"
#include "extract/detail/net_points.hpp"
#include "extract/detail/net_relaxation.hpp"
#include "extract/detail/net_volumes.hpp"
#include "extract/detail/sparse_label_rows.hpp"
#include "extract/detail/voxel_input.hpp"

namespace isoextract::extract {
namespace {

constexpr std::size_t kMostChunks = 8192;  // to count

// Sums over a part of the chunks.
struct Counts {
  std::uint64_t parts = 0;    // labels of a chunk, summed over the chunks
  std::uint64_t mixed = 0;    // those in chunks that have other labels, too, or none in some voxels
  std::uint64_t chunks = 0;   // chunks with points
  std::uint64_t points = 0;   // voxel corners between different labels
  std::uint64_t corners = 0;  // points that are corners of merged faces
  std::uint64_t faces = 0;    // voxel faces between different labels
  std::unordered_map<std::int64_t, std::uint64_t> sides_of;

  void add(const Counts& more) {
    parts += more.parts;
    mixed += more.mixed;
    chunks += more.chunks;
    points += more.points;
    corners += more.corners;
    faces += more.faces;
    for (const auto& [label, count] : more.sides_of) sides_of[label] += count;
  }
};

// Indices of voxels in a window: a chunk and the layers of voxels one step below it.
constexpr glm::ivec3 kWindow = kVoxelChunk + 1;
constexpr std::size_t place_of(int x, int y, int z) {
  const int place = x + kWindow.x * (y + kWindow.y * z);
  return static_cast<std::size_t>(place);
}
// Index steps from a voxel down to the voxels that share its lowest corner: along x for bit 0, y for bit 1, z for
// bit 2.
constexpr std::array<std::size_t, 8> kBelow{0,
                                            place_of(1, 0, 0),
                                            place_of(0, 1, 0),
                                            place_of(1, 1, 0),
                                            place_of(0, 0, 1),
                                            place_of(1, 0, 1),
                                            place_of(0, 1, 1),
                                            place_of(1, 1, 1)};

// The labels of a chunk of voxels, and of the voxels one step below it along each axis.
class LabelWindow {
 public:
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::min();

  // rows_at(origin) returns the rows of samples of a chunk (SampleRows).
  template <class RowsAt>
  LabelWindow(const glm::ivec3& origin, const LabelFilter& filter, RowsAt& rows_at) {
    labels_.fill(kNone);
    for (int n = 0; n < 8; ++n) {
      const glm::ivec3 below(n & 1, n >> 1 & 1, n >> 2);
      put(rows_at(origin - kVoxelChunk * below), below, filter);
    }
  }

  // Counts the different labels in the chunk.
  void count_labels(Counts& counts) const {
    std::vector<std::int64_t> found;
    std::int64_t last = kNone;
    bool is_mixed = false;
    for (int z = 1; z <= kVoxelChunk.z; ++z) {
      for (int y = 1; y <= kVoxelChunk.y; ++y) {
        for (std::size_t place = place_of(1, y, z); place < place_of(kVoxelChunk.x + 1, y, z); ++place) {
          const std::int64_t label = labels_[place];
          is_mixed |= label != labels_[place_of(1, 1, 1)];
          if (label == last || label == kNone) continue;
          last = label;
          if (std::ranges::find(found, label) == found.end()) found.push_back(label);
        }
      }
    }
    counts.parts += found.size();
    if (is_mixed) counts.mixed += found.size();
  }

  // Counts the corners and faces at the lower sides of the chunk's voxels.
  void count(Counts& counts) const {
    const std::uint64_t points_before = counts.points;
    Faces faces(counts);
    for (int z = 1; z <= kVoxelChunk.z; ++z) {
      for (int y = 1; y <= kVoxelChunk.y; ++y) {
        for (std::size_t place = place_of(1, y, z); place < place_of(kVoxelChunk.x + 1, y, z); ++place) {
          const std::int64_t label = labels_[place];
          bool differ = false;
          for (std::size_t n = 1; n < 8; ++n) differ |= labels_[place - kBelow[n]] != label;
          if (!differ) continue;
          ++counts.points;
          counts.corners += is_corner(place) ? 1 : 0;
          for (const std::size_t n : {1, 2, 4}) faces.add(label, labels_[place - kBelow[n]]);
        }
      }
    }
    counts.chunks += counts.points > points_before ? 1 : 0;
  }

 private:
  // Returns whether merged faces have a corner at the lowest corner of a voxel. Within flat faces and along straight
  // edges, the eight voxels there have equal labels in pairs along some axis; at a corner they do not.
  [[nodiscard]] bool is_corner(std::size_t place) const {
    for (const std::size_t axis : {1, 2, 4}) {
      bool agree = true;
      for (std::size_t n = 0; n < 8; ++n)
        agree = agree && labels_[place - kBelow[n]] == labels_[place - kBelow[n ^ axis]];
      if (agree) return false;
    }
    return true;
  }

  // Sums the faces of a label before it looks the label up: neighboring voxels usually have the same label.
  class Faces {
   public:
    explicit Faces(Counts& counts) : counts_(counts) {}
    Faces(const Faces&) = delete;
    Faces& operator=(const Faces&) = delete;
    ~Faces() {
      for (const auto& [label, count] : latest_) flush(label, count);
    }

    void add(std::int64_t label, std::int64_t other) {
      if (label == other) return;
      ++counts_.faces;
      for (const std::int64_t side : {label, other}) {
        auto& [of, count] = latest_[static_cast<std::uint64_t>(side) % latest_.size()];
        if (of != side) flush(of, count);
        count = (of == side ? count : 0) + 1;
        of = side;
      }
    }

   private:
    void flush(std::int64_t label, std::uint64_t count) {
      if (label != kNone && count > 0) counts_.sides_of[label] += count;
    }

    Counts& counts_;
    std::array<std::pair<std::int64_t, std::uint64_t>, 16> latest_{};
  };

  // `below` is 1 along each axis along which `rows` is the chunk below the window's own chunk, else 0.
  template <class T>
  void put(const SampleRows<T>& rows, const glm::ivec3& below, const LabelFilter& filter) {
    const int first = std::max(rows.begin, below.x != 0 ? kVoxelChunk.x - 1 : 0);
    std::int64_t last_label = kNone;
    bool is_wanted = false;
    const auto put_one = [&](const glm::ivec3& voxel, std::int64_t label) {
      if (label != last_label) is_wanted = filter(label);
      last_label = label;
      const glm::ivec3 at = voxel + 1 - kVoxelChunk * below;
      if (is_wanted) labels_[place_of(at.x, at.y, at.z)] = label;
    };
    for (int z = below.z != 0 ? kVoxelChunk.z - 1 : 0; z < kVoxelChunk.z; ++z) {
      for (int y = below.y != 0 ? kVoxelChunk.y - 1 : 0; y < kVoxelChunk.y; ++y) {
        const T* const row = rows.rows[chunk_row(y, z)];
        if (row == nullptr) continue;
        for (int x = first; x < rows.end; ++x) {
          if (!is_no_number(row[x]) && is_label(row[x])) put_one({x, y, z}, static_cast<std::int64_t>(row[x]));
        }
      }
    }
  }

  std::array<std::int64_t, place_of(0, 0, kWindow.z)> labels_;
};

// The chunks to count; each stands for `scale` chunks.
struct ChunkSample {
  std::vector<glm::ivec3> origins;
  double scale = 1;
};

// Takes every n-th row of chunks along x; n has no factor in common with the number of rows in a layer.
ChunkSample sample_of_dense(const glm::ivec3& dims) {
  const ChunkGrid grid({glm::ivec3(0), dims});  // one sample more along each axis, for the upper faces of the data
  const auto rows = static_cast<std::uint64_t>(grid.size.y * grid.size.z);
  const auto row_chunks = static_cast<std::uint64_t>(grid.size.x);
  std::uint64_t step = (rows * row_chunks + kMostChunks - 1) / kMostChunks;
  while (std::gcd(step, static_cast<std::uint64_t>(grid.size.y)) > 1) ++step;
  ChunkSample sample;
  std::uint64_t taken = 0;
  for (std::uint64_t row = step / 2; row < rows; row += step, ++taken) {
    for (std::uint64_t x = 0; x < row_chunks; ++x) sample.origins.push_back(grid.origin(row * row_chunks + x));
  }
  sample.scale = taken > 0 ? static_cast<double>(rows) / static_cast<double>(taken) : 1;
  return sample;
}

ChunkSample sample_of_sparse(const std::vector<glm::ivec3>& listed) {
  std::vector<glm::ivec3> all;
  all.reserve(8 * listed.size());
  for (const glm::ivec3& origin : listed) {
    for (int n = 0; n < 8; ++n) all.push_back(origin + chunk_step(n));
  }
  const auto before = [](const glm::ivec3& a, const glm::ivec3& b) { return chunk_order(a) < chunk_order(b); };
  std::sort(all.begin(), all.end(), before);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  const std::size_t step = (all.size() + kMostChunks - 1) / kMostChunks;
  ChunkSample sample;
  for (std::size_t n = step / 2; n < all.size(); n += step) sample.origins.push_back(all[n]);
  sample.scale =
      sample.origins.empty() ? 1 : static_cast<double>(all.size()) / static_cast<double>(sample.origins.size());
  return sample;
}

// make_rows() returns a function for LabelWindow.
template <class MakeRows>
Counts count_chunks(const ChunkSample& sample, const LabelFilter& filter, const Context& context,
                    const MakeRows& make_rows) {
  constexpr std::size_t kGrain = 64;
  return reduce_ranges(
      sample.origins.size(), kGrain, Counts(),
      [&](std::size_t begin, std::size_t end, Counts counts) {
        auto rows = make_rows();
        for (std::size_t n = begin; n < end && !context.cancelled(); ++n) {
          const LabelWindow window(sample.origins[n], filter, rows);
          window.count(counts);
          window.count_labels(counts);
        }
        return counts;
      },
      [](Counts a, const Counts& b) {
        a.add(b);
        return a;
      });
}

template <class T>
struct DenseRows {
  DenseView<T> view;

  SampleRows<T> operator()(const glm::ivec3& origin) const {
    const bool is_outside =
        glm::any(glm::lessThan(origin, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(origin, view.dims));
    return is_outside ? SampleRows<T>() : dense_rows(view, origin);
  }
};

Counts count_dense(const field::DenseSamples& samples, const field::IndexBox& region, const LabelFilter& filter,
                   const Context& context, double& scale) {
  const ChunkSample sample = sample_of_dense(glm::ivec3(region.dims()));
  scale = sample.scale;
  return field::visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) {
    const DenseView<T> view = part_of(dense_view<T>(samples), region);
    return count_chunks(sample, filter, context, [&] { return DenseRows<T>{view}; });
  });
}

Result<Counts> count_sparse(const field::ScalarField& field, const field::SparseSamples& samples,
                            const field::IndexBox& region, const LabelFilter& filter, const Context& context,
                            double& scale) {
  const SparseLabelRows map = TRY(SparseLabelRows::make(field, samples, region, context, field.source));
  const SparseLabelRows::Chunks chunks = TRY(map.chunks(context));
  const ChunkSample sample = sample_of_sparse(chunks.origins);
  scale = sample.scale;
  return field::visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) {
    return count_chunks(sample, filter, context, [&] {
      return [rows = map.rows<T>()](const glm::ivec3& origin) mutable -> const SampleRows<T>& {
        return rows.read(origin);
      };
    });
  });
}

std::uint64_t scaled(std::uint64_t count, double scale) {
  return static_cast<std::uint64_t>(static_cast<double>(count) * scale);
}

// Sets the bytes of surfaces. `parts`: labels of a chunk, summed over the chunks. `share`: the fraction of the points
// between labels that become vertices.
void set_surface_bytes(LabelMapSize& size, std::uint64_t parts, double share) {
  const auto threads = static_cast<std::uint64_t>(usable_threads());
  const bool has_groups = threads > 1 && parts <= size.labels * kSmallLabelChunks;
  const std::uint64_t group_sides = has_groups ? size.sides / parts * 2 * kSmallLabelChunks : 0;
  // Each thread lists the faces of the label that it works on.
  const std::uint64_t listed = std::min(threads * size.largest_sides, size.sides);
  // About a vertex and two triangles for each face.
  const std::uint64_t side_bytes = sizeof(glm::vec3) + 2 * sizeof(glm::uvec3);
  const auto mesh_bytes = [&](std::uint64_t sides) { return scaled(sides * side_bytes, share); };
  size.listing_bytes = scaled(listed * sizeof(FaceRectangle), share);
  size.group_bytes = mesh_bytes(std::max(size.largest_sides, std::min(size.sides, group_sides)));
  size.largest_bytes = mesh_bytes(size.largest_sides);
  size.mesh_bytes = mesh_bytes(size.sides);
}

}  // namespace

Result<LabelMapSize> estimate_label_map(const field::ScalarField& field, const ExtractOptions& options,
                                        const LabelChoice& choice, const Context& context) {
  const auto bounds = TRY(label_bounds(field, options));
  const auto* dense = std::get_if<field::DenseSamples>(&field.samples);
  const auto* sparse = std::get_if<field::SparseSamples>(&field.samples);
  const bool nets = options.method == Method::surface_nets;
  const LabelFilter filter(choice, nets, label_around(sparse), LabelIds(field.label_ids));
  double scale = 1;
  Counts counts;
  if (dense != nullptr) {
    counts = count_dense(*dense, bounds.region, filter, context, scale);
  } else {
    counts = TRY(count_sparse(field, *sparse, bounds.region, filter, context, scale));
  }
  TRY(context.check());
  LabelMapSize size;
  const LabelFilter chosen(choice, false, label_around(sparse), LabelIds(field.label_ids));
  for (const auto& [label, sides] : counts.sides_of) {
    if (!chosen(label)) continue;
    ++size.labels;
    size.sides += scaled(sides, scale);
    size.largest_sides = std::max(size.largest_sides, scaled(sides, scale));
  }
  size.faces = std::min(scaled(counts.faces, scale), size.sides);
  const std::uint64_t parts = std::max<std::uint64_t>(scaled(counts.parts, scale), 1);
  const bool has_all_points = nets || options.voxel_faces == VoxelFaces::plain || counts.points == 0;
  const double share = has_all_points ? 1 : static_cast<double>(counts.corners) / static_cast<double>(counts.points);
  set_surface_bytes(size, parts, share);
  const std::uint64_t bits = scaled(counts.mixed, scale) * sizeof(ChunkBits);
  const std::uint64_t most_bits = LabelBits::most_in_memory(context, nets);
  size.voxel_bytes = parts * (sizeof(LabelPart) + 2 * sizeof(std::uintptr_t)) + std::min(bits, most_bits);
  size.kept_bytes = size.finding_bytes = size.voxel_bytes;
  if (!nets) return size;
  const std::uint64_t chunks = scaled(counts.chunks, scale);
  const std::uint64_t points = scaled(counts.points, scale);
  const std::uint64_t faces = scaled(counts.faces, scale);
  const std::uint64_t rounds = options.relaxations;
  if (bits > most_bits || NetPoints::prefers_files(points, faces, chunks, rounds, context)) {
    size.finding_bytes +=
        LabelChunks::bytes(parts) + NetPoints::list_bytes(chunks, rounds) + NetMemory::run_bytes(context);
    size.kept_bytes += NetPoints::list_bytes(chunks, 0);
  } else {
    size.finding_bytes += LabelChunks::bytes(parts) + NetPoints::making_bytes(points, faces, chunks, rounds);
    size.kept_bytes += NetPoints::bytes(points, chunks);
  }
  return size;
}

}  // namespace isoextract::extract

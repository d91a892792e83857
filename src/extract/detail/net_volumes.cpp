#include "extract/detail/net_volumes.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "extract/detail/corner_words.hpp"
#include "extract/detail/net_face_size.hpp"
#include "extract/detail/net_faces.hpp"
#include "extract/detail/net_relaxation.hpp"
#include "extract/detail/reserved_list.hpp"
#include "extract/detail/voxel_input.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {
namespace {

// Volumes and areas are sums of integers, so that the order of the threads does not change them. Sums may wrap around
// on the way; only their final value must fit.
constexpr double kUnits = 1 << 24;  // per grid step cubed
std::uint64_t to_units(double value) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(value * kUnits)); }
double from_units(std::uint64_t sum) { return static_cast<double>(static_cast<std::int64_t>(sum)) / kUnits; }

constexpr int kMostPasses = 40;
constexpr int kCoupledPasses = 2;      // choose the steps of all shells together
constexpr float kLongestStep = 0.25F;  // of a point in one pass, in grid steps
constexpr double kLeastGain = 0.5;
constexpr double kMostGain = 4;

struct Shell {
  std::uint64_t excess = 0;  // volume of the net minus volume of the voxels
  std::uint64_t area = 0;
  double voxels = 0;  // volume; negative for a cavity
  double before = 0;  // the excess before the last move
  double wanted = 0;  // the change of volume for which `step` was chosen
  float step = 0;     // outward, in grid steps
  double gain = 1;    // corrects steps by the change of volume that the last one achieved

  [[nodiscard]] bool is_right() const { return std::abs(from_units(excess)) <= kNetVolumeTolerance * std::abs(voxels); }
};

// Sums the faces of a chunk by shell, so that few sums are added to the shells that all threads share.
class ShellSums {
 public:
  explicit ShellSums(std::vector<Shell>& shells) : shells_(shells) {}
  ShellSums(const ShellSums&) = delete;
  ShellSums& operator=(const ShellSums&) = delete;
  ~ShellSums() {
    for (const Sum& sum : sums_) flush(sum);
  }

  // Adds the area of a face to the shells below and above it. Adds the volume to the shell below, and subtracts it from
  // the shell above.
  void add(const NetFaces::Shells& shells, std::uint64_t volume, std::uint64_t area) {
    add(shells[0], volume, area);
    add(shells[1], ~volume + 1, area);
  }

 private:
  struct Sum {
    std::uint64_t volume = 0;
    std::uint64_t area = 0;
    std::uint32_t shell = NetFaces::kNoShell;
  };

  void add(std::uint32_t shell, std::uint64_t volume, std::uint64_t area) {
    Sum& sum = sums_[shell % sums_.size()];
    if (shell != sum.shell) {
      flush(sum);
      sum = {0, 0, shell};
    }
    sum.volume += volume;
    sum.area += area;
  }

  void flush(const Sum& sum) {
    if (sum.shell == NetFaces::kNoShell) return;
    Shell& shell = shells_[sum.shell];
    std::atomic_ref(shell.excess).fetch_add(sum.volume, std::memory_order_relaxed);
    std::atomic_ref(shell.area).fetch_add(sum.area, std::memory_order_relaxed);
  }

  std::vector<Shell>& shells_;
  std::array<Sum, 64> sums_;  // the latest ones
};

// The areas that shells have in common, by chunk.
class ShellLinks {
 public:
  struct Link {
    NetFaces::Shells shells;
    std::uint32_t area;  // that can move, in kAreaUnits
  };

  // Bytes besides the links.
  static constexpr std::uint64_t kBytesPerShell = 5 * sizeof(double);
  static constexpr std::uint64_t kBytesPerChunk = sizeof(ReservedList<Link>);

  ShellLinks(std::size_t chunks, const Context& context, const std::string& what) {
    of_chunks_.reserve(chunks);
    for (std::size_t c = 0; c < chunks; ++c) of_chunks_.emplace_back(context, what);
  }

  // Sums the areas of one chunk.
  class OfChunk {
   public:
    OfChunk(ShellLinks& links, std::size_t chunk, std::size_t faces)
        : list_(links.of_chunks_[chunk]), table_(std::bit_ceil(2 * faces + 1)) {}

    void add(const NetFaces::Shells& shells, float square_steps) {
      const auto area = static_cast<std::uint32_t>(static_cast<double>(square_steps) * kAreaUnits);
      const std::size_t mask = table_.size() - 1;
      std::size_t at = ((shells[0] * 0x9E3779B1U ^ shells[1] * 0x85EBCA77U) >> 8) & mask;
      for (; table_[at] != 0; at = (at + 1) & mask) {
        Link& link = list_.values()[table_[at] - 1];
        if (link.shells == shells) {
          link.area += area;
          return;
        }
      }
      if (list_.add({shells, area})) table_[at] = static_cast<std::uint16_t>(list_.values().size());
    }

   private:
    ReservedList<Link>& list_;
    std::vector<std::uint16_t> table_;  // number of each link, plus 1; 0: none
  };

  // Fails if memory ran out.
  [[nodiscard]] Result<void> check() const {
    for (const ReservedList<Link>& list : of_chunks_) {
      if (list.error()) return tl::unexpected(*list.error());
    }
    return {};
  }

  // Returns whether any shell of a chunk makes a step.
  [[nodiscard]] bool any_step(std::size_t chunk, const std::vector<Shell>& shells) const {
    const auto moves = [&](std::uint32_t shell) { return shell != NetFaces::kNoShell && shells[shell].step != 0; };
    return std::ranges::any_of(of_chunks_[chunk].values(),
                               [&](const Link& link) { return moves(link.shells[0]) || moves(link.shells[1]); });
  }

  // Chooses steps that together change all volumes as wanted, if no cell limits them. The change is a linear function
  // of the steps, with a symmetric matrix. Scaled by its diagonal, the matrix has eigenvalues from 0 to 2:
  // Chebyshev's iteration needs nothing else. Sums are of integers, so they depend neither on the order of the shells
  // nor on the chunks.
  void solve(std::vector<Shell>& shells) const {
    constexpr int kRounds = 16;
    constexpr double kLowest = 0.1;  // steps that are nearly equal for all shells change no volume, and are left out
    constexpr double kMiddle = (2 + kLowest) / 2;
    constexpr double kHalf = (2 - kLowest) / 2;
    const std::size_t count = shells.size();
    std::vector<std::int64_t> diagonal(count, 0);
    for_each_link([&](std::uint32_t a, std::uint32_t b, std::int64_t area) {
      diagonal[a] += area;
      if (b != NetFaces::kNoShell) diagonal[b] += area;
    });
    const auto scaled = [&](std::size_t s, double change) {
      constexpr double kMost = 8;  // no point moves that far; keeps products small
      return diagonal[s] > 0 ? std::clamp(change / (static_cast<double>(diagonal[s]) / kLinkUnits), -kMost, kMost)
                             : 0.0;
    };
    std::vector<double> rest(count);
    std::vector<std::int64_t> way(count);
    std::vector<std::int64_t> steps(count, 0);
    std::vector<std::int64_t> change(count);
    for (std::size_t s = 0; s < count; ++s) {
      rest[s] = -shells[s].gain * from_units(shells[s].excess);
      way[s] = std::llround(scaled(s, rest[s]) / kMiddle * kStepUnits);
    }
    double factor = kHalf / kMiddle;
    for (int round = 0; round < kRounds; ++round) {
      std::ranges::fill(change, 0);
      for_each_link([&](std::uint32_t a, std::uint32_t b, std::int64_t area) {
        const std::int64_t flow = area * (b == NetFaces::kNoShell ? way[a] : way[a] - way[b]);
        change[a] += flow;
        if (b != NetFaces::kNoShell) change[b] -= flow;
      });
      const double next = 1 / (2 * kMiddle / kHalf - factor);
      for (std::size_t s = 0; s < count; ++s) {
        steps[s] += way[s];
        rest[s] -= static_cast<double>(change[s]) / (kLinkUnits * kStepUnits);
        way[s] = std::llround(next * factor * static_cast<double>(way[s]) +
                              2 * next / kHalf * scaled(s, rest[s]) * kStepUnits);
      }
      factor = next;
    }
    for (std::size_t s = 0; s < count; ++s) {
      shells[s].step = static_cast<float>(std::clamp(static_cast<double>(steps[s]) / kStepUnits, -1.0, 1.0));
    }
  }

 private:
  static constexpr double kAreaUnits = 1 << 16;         // per square grid step
  static constexpr double kLinkUnits = 2 * kAreaUnits;  // of for_each_link()
  static constexpr double kStepUnits = 1 << 20;         // per grid step

  // Calls f(shell, other, area) for all links; `other` may be kNoShell. The area is in units of 1 / kLinkUnits square
  // grid steps, and a face between two shells counts half.
  template <class F>
  void for_each_link(const F& f) const {
    for (const ReservedList<Link>& list : of_chunks_) {
      for (const Link& link : list.values()) {
        const auto [below, above] = link.shells;
        const auto area = static_cast<std::int64_t>(link.area);
        if (below == NetFaces::kNoShell) {
          f(above, below, 2 * area);
        } else {
          f(below, above, above == NetFaces::kNoShell ? 2 * area : area);
        }
      }
    }
  }

  std::vector<ReservedList<Link>> of_chunks_;
};

class VolumeKeeper {
 public:
  VolumeKeeper(const NetGrid& grid, const NetFaces& faces, const field::IndexBox& bounds,
               const glm::dmat3& output_from_index, Buffer<glm::vec3>& areas, Buffer<glm::vec3>& offsets)
      : grid_(grid),
        faces_(faces),
        bounds_(bounds),
        sizes_(offsets, output_from_index),
        areas_(areas),
        offsets_(offsets),
        shells_(faces.shells()),
        has_steps_(grid.origins().size()),
        is_marked_(grid.origins().size()),
        moving_(grid.origins().size()) {}

  // Returns the bytes that a keeper takes in addition to the constructor's arguments.
  static std::uint64_t bytes(std::uint64_t shells, std::uint64_t chunks) {
    return shells * (sizeof(Shell) + ShellLinks::kBytesPerShell) +
           chunks * (ShellLinks::kBytesPerChunk + 2 + sizeof(ChunkBits));
  }

  Result<void> run(const Context& context, const std::string& what) {
    measure_voxels();
    measure_all();
    const ShellLinks links = TRY(link_shells(context, what));
    for (int pass = 0; pass < kMostPasses; ++pass) {
      TRY(context.check());
      if (!choose_changes()) break;
      if (pass < kCoupledPasses) {
        links.solve(shells_);
      } else {
        choose_steps_alone();
      }
      for_each_index(grid_.origins().size(),
                     [&](std::size_t c) { has_steps_[c] = links.any_step(c, shells_) ? 1 : 0; });
      // Adding faces to the sums once is less work than to add and subtract most of them.
      if (2 * std::ranges::count(has_steps_, 1) > static_cast<std::ptrdiff_t>(has_steps_.size())) {
        move_points([](std::size_t, std::size_t) { return ~std::uint64_t{0}; });
        measure_all();
      } else {
        mark_moving();
        add_moving(-1);
        move_points([&](std::size_t c, std::size_t row) { return is_marked_[c] != 0 ? moving_[c][row] : 0; });
        add_moving(1);
      }
    }
    return {};
  }

 private:
  // Returns the number of the chunk at chunk_step(n) from another.
  [[nodiscard]] std::int32_t upper(std::size_t chunk, unsigned n) const {
    return grid_.near(chunk)[13 + (n & 1) + 3 * (n >> 1 & 1) + 9 * (n >> 2)];
  }

  void measure_voxels() {
    for_each_index(grid_.origins().size(), [&](std::size_t c) {
      ShellSums sums(shells_);
      faces_.for_each_of_chunk(grid_, c, [&](std::size_t number, int axis, const glm::ivec3& corner) {
        if (axis != 0) return;  // the faces across one axis tell the volume
        sums.add(faces_.shells_of(number), to_units(grid_.origins()[c].x + corner.x), 0);
      });
    });
    for (Shell& shell : shells_) shell.voxels = from_units(std::exchange(shell.excess, 0));
  }

  // Sums the areas that shells have in common.
  Result<ShellLinks> link_shells(const Context& context, const std::string& what) {
    ShellLinks links(grid_.origins().size(), context, what);
    for_each_index(grid_.origins().size(), [&](std::size_t c) {
      ShellLinks::OfChunk areas(links, c, faces_.first_of_row(c, 64) - faces_.first_of_row(c, 0));
      faces_.for_each_of_chunk(grid_, c, [&](std::size_t number, int axis, const glm::ivec3& corner) {
        const bool is_fixed = (fixed_axes(grid_.origins()[c] + corner, bounds_) >> axis & 1) != 0;
        areas.add(faces_.shells_of(number), is_fixed ? 0.0F : glm::length(areas_[number]));
      });
    });
    TRY(links.check());
    return links;
  }

  void measure_all() {
    for (Shell& shell : shells_) shell.excess = shell.area = 0;
    for_each_index(grid_.origins().size(),
                   [&](std::size_t c) { add_faces(c, 1, [](std::size_t) { return ~std::uint64_t{0}; }); });
  }

  // Adds the faces of a chunk whose first point is in which(row) to the sums of their shells, times `sign`.
  template <class Which>
  void add_faces(std::size_t chunk, int sign, const Which& which) {
    const NearPoints near(grid_, chunk);
    ShellSums sums(shells_);
    const auto factor = static_cast<std::uint64_t>(std::int64_t{sign});
    grid_.for_each_row(chunk, [&](const NetGrid::Row& row, int y, int z) {
      const std::uint64_t asked = which(chunk_row(y, z));
      if ((asked & row.used) == 0) return;
      std::uint32_t number = faces_.first_of_row(chunk, chunk_row(y, z));
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) {
        const unsigned axes = faces_.own_axes(k++);
        if ((asked >> bit & 1) == 0) {
          number += static_cast<std::uint32_t>(count_bits(axes));
          return;
        }
        for_each_bit(axes, [&](int axis) {
          const NetFaceSize size = sizes_.of(near, NearPlaces::of(bit, y, z), axis);
          areas_[number] = size.area;
          sums.add(faces_.shells_of(number), factor * to_units(size.volume), factor * to_units(glm::length(size.area)));
          ++number;
        });
      });
    });
  }

  // Marks the corner points of all faces that make a step.
  void mark_moving() {
    std::ranges::fill(is_marked_, std::uint8_t{0});
    // Clears the bits of all chunks that may get marked points, before any thread sets bits.
    for (std::size_t c = 0; c < has_steps_.size(); ++c) {
      if (has_steps_[c] == 0) continue;
      for (unsigned n = 0; n < 8; ++n) {
        const std::int32_t up = upper(c, n);
        if (up < 0 || std::exchange(is_marked_[static_cast<std::size_t>(up)], std::uint8_t{1}) != 0) continue;
        moving_[static_cast<std::size_t>(up)].fill(0);
      }
    }
    for_each_index(grid_.origins().size(), [&](std::size_t c) {
      if (has_steps_[c] == 0) return;
      faces_.for_each_of_chunk(grid_, c, [&](std::size_t number, int axis, const glm::ivec3& corner) {
        if (step_of(faces_.shells_of(number)) == 0) return;
        for (int n = 0; n < 4; ++n) {
          glm::ivec3 at = corner;
          at[(axis + 1) % 3] += n & 1;
          at[(axis + 2) % 3] += n >> 1;
          const auto up = static_cast<unsigned>(at.x >> 6 | at.y >> 3 << 1 | at.z >> 3 << 2);
          std::uint64_t& word = moving_[static_cast<std::size_t>(upper(c, up))][chunk_row(at.y, at.z)];
          std::atomic_ref(word).fetch_or(std::uint64_t{1} << (at.x & 63), std::memory_order_relaxed);
        }
      });
    });
  }

  // Adds the faces with marked points to the sums, times a sign.
  void add_moving(int sign) {
    for_each_index(grid_.origins().size(), [&](std::size_t c) {
      std::array<const ChunkBits*, 8> near{};
      bool any = false;
      for (unsigned n = 0; n < near.size(); ++n) {
        const std::int32_t number = upper(c, n);
        const auto up = static_cast<std::size_t>(number);
        const bool is_marked = number >= 0 && is_marked_[up] != 0;
        near[n] = is_marked ? &moving_[up] : &empty_chunk();
        any |= is_marked;
      }
      if (!any) return;
      add_faces(c, sign, [&](std::size_t row) {
        std::uint64_t found = 0;
        for (int n = 0; n < 4; ++n) {
          const int y = static_cast<int>(row & 7) + (n & 1);
          const int z = static_cast<int>(row >> 3) + (n >> 1);
          const auto chunk = static_cast<std::size_t>(y >> 3 << 1 | z >> 3 << 2);
          const std::uint64_t word = (*near[chunk])[chunk_row(y, z)];
          found |= word | word >> 1 | (*near[chunk | 1])[chunk_row(y, z)] << 63;
        }
        return found;
      });
    });
  }

  // Chooses by how much the volume of each shell is to change. Returns false if no volume is to change.
  bool choose_changes() {
    bool any = false;
    for (Shell& shell : shells_) {
      const double excess = from_units(shell.excess);
      if (shell.wanted != 0) {
        const double got = excess - shell.before;
        const double ratio = got * shell.wanted > 0 ? shell.wanted / got : kMostGain;
        shell.gain = std::clamp(shell.gain * std::clamp(ratio, 0.5, 2.0), kLeastGain, kMostGain);
      }
      shell.before = excess;
      shell.wanted = shell.is_right() ? 0 : -excess;
      any |= shell.wanted != 0;
    }
    return any;
  }

  // Chooses the steps as if no other shell moved.
  void choose_steps_alone() {
    for (Shell& shell : shells_) {
      const double area = from_units(shell.area);
      shell.step = area > 0 ? static_cast<float>(std::clamp(shell.gain * shell.wanted / area, -1.0, 1.0)) : 0;
    }
  }

  // Moves the points in which(chunk, row) by the steps of the faces around them.
  template <class Which>
  void move_points(const Which& which) {
    for_each_index(grid_.origins().size(), [&](std::size_t c) {
      std::optional<NearFaces> near;
      grid_.for_each_row(c, [&](const NetGrid::Row& row, int y, int z) {
        const std::uint64_t asked = which(c, chunk_row(y, z));
        if ((asked & row.used) == 0) return;
        if (!near) near.emplace(grid_, faces_, c);
        const RowFixedAxes fixed(grid_.origins()[c] + glm::ivec3(0, y, z), bounds_);
        std::uint32_t k = row.first;
        for_each_bit(row.used, [&](int bit) {
          if ((asked >> bit & 1) != 0) move_point(*near, NearPlaces::of(bit, y, z), k, fixed.at(bit));
          ++k;
        });
      });
    });
  }

  void move_point(const NearFaces& near, int place, std::uint32_t k, unsigned fixed) {
    glm::vec3 way(0);
    float count = 0;
    for_each_bit(faces_.sides(k), [&](int side) {
      const std::uint32_t number = near.number(place, side);
      count += 1;
      const float step = step_of(faces_.shells_of(number));
      if (step == 0) return;
      const glm::vec3& area = areas_[number];
      const float squared = glm::dot(area, area);
      if (squared > 0) way += step / std::sqrt(squared) * area;
    });
    if (way == glm::vec3(0)) return;
    way /= count;
    way *= std::min(1.0F, kLongestStep / glm::length(way));
    offsets_[k] = offset_within_cell(offsets_[k] + way, fixed);
  }

  // Returns how far a face moves toward its upper side.
  [[nodiscard]] float step_of(const NetFaces::Shells& shells) const {
    const auto outward = [&](std::uint32_t shell) { return shell == NetFaces::kNoShell ? 0 : shells_[shell].step; };
    const bool is_shared = shells[0] != NetFaces::kNoShell && shells[1] != NetFaces::kNoShell;
    return (is_shared ? 0.5F : 1.0F) * (outward(shells[0]) - outward(shells[1]));
  }

  const NetGrid& grid_;
  const NetFaces& faces_;
  field::IndexBox bounds_;
  NetFaceSizes sizes_;
  Buffer<glm::vec3>& areas_;  // of the faces, as area vectors
  Buffer<glm::vec3>& offsets_;
  std::vector<Shell> shells_;
  std::vector<std::uint8_t> has_steps_;  // of each chunk: any of its shells makes a step
  std::vector<std::uint8_t> is_marked_;  // of each chunk: moving_ is valid, and may have points
  Buffer<ChunkBits> moving_;             // the points that the pass moves
};

}  // namespace

Result<void> keep_volumes(const NetGrid& grid, const LabelChunks& labels, const glm::dmat3& output_from_index,
                          Buffer<glm::vec3>& offsets, const Context& context, const std::string& what) {
  const NetFaces faces = TRY(NetFaces::make(grid, labels, context, what));
  auto areas = TRY(make_reserved_buffer<glm::vec3>(faces.size(), context, what));
  const auto held = TRY(context.reserve(VolumeKeeper::bytes(faces.shells(), grid.origins().size()), what));
  return VolumeKeeper(grid, faces, labels.bounds(), output_from_index, areas->values, offsets).run(context, what);
}

std::uint64_t volume_keeping_bytes(std::uint64_t points, std::uint64_t faces, std::uint64_t chunks) {
  return NetFaces::bytes(points, faces, chunks) + faces * sizeof(glm::vec3) + VolumeKeeper::bytes(0, chunks);
}

}  // namespace isoextract::extract

#include "extract/detail/net_volumes.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <vector>

#include <glm/gtc/matrix_inverse.hpp>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "extract/detail/net_faces.hpp"
#include "extract/detail/net_relaxation.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {
namespace {

// Volumes and areas are sums of integers, so that the order of the threads does not change them. Sums may wrap around
// on the way; only their final value must fit.
constexpr double kUnits = 1 << 24;  // per grid step cubed
std::uint64_t to_units(double value) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(value * kUnits)); }
double from_units(std::uint64_t sum) { return static_cast<double>(static_cast<std::int64_t>(sum)) / kUnits; }

constexpr int kMostPasses = 40;
constexpr float kLongestStep = 0.25F;  // of a point in one pass
constexpr double kLeastGain = 0.5;
constexpr double kMostGain = 4;
constexpr std::size_t kPerBlock = 1 << 12;  // faces or points that one task visits
std::size_t blocks_of(std::size_t count) { return (count + kPerBlock - 1) / kPerBlock; }

// The corners of a face across an axis, from the first one.
using Corners = std::array<glm::dvec3, 4>;
constexpr std::array<Corners, 3> kCorners{
    Corners{glm::dvec3(0), glm::dvec3(0, 1, 0), glm::dvec3(0, 1, 1), glm::dvec3(0, 0, 1)},
    Corners{glm::dvec3(0), glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 1), glm::dvec3(1, 0, 0)},
    Corners{glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(1, 1, 0), glm::dvec3(0, 1, 0)}};

struct Shell {
  std::uint64_t excess = 0;  // volume of the net minus volume of the voxels
  std::uint64_t area = 0;
  double voxels = 0;  // volume; negative for a cavity
  double before = 0;  // the excess before the last move
  double wanted = 0;  // the change of volume for which `step` was chosen
  float step = 0;     // outward, in grid steps
  double gain = 1;    // corrects steps by the change of volume that the last one achieved

  // Was right twice in a row. Once is not enough, as the moves for its neighbors may change it again.
  bool is_settled = false;
  bool was_right = false;

  [[nodiscard]] bool is_right() const { return std::abs(from_units(excess)) <= kNetVolumeTolerance * std::abs(voxels); }
};

// Adds the sums of consecutive faces of one shell at once.
class ShellSums {
 public:
  explicit ShellSums(std::vector<Shell>& shells) : shells_(shells) {}
  ShellSums(const ShellSums&) = delete;
  ShellSums& operator=(const ShellSums&) = delete;
  ~ShellSums() { flush(); }

  void add(std::uint32_t shell, std::uint64_t excess, std::uint64_t area) {
    if (shell != shell_) {
      flush();
      shell_ = shell;
      excess_ = area_ = 0;
    }
    excess_ += excess;
    area_ += area;
  }

 private:
  void flush() {
    if (shell_ == NetFaces::kNoShell) return;
    Shell& shell = shells_[shell_];
    std::atomic_ref(shell.excess).fetch_add(excess_, std::memory_order_relaxed);
    std::atomic_ref(shell.area).fetch_add(area_, std::memory_order_relaxed);
  }

  std::vector<Shell>& shells_;
  std::uint32_t shell_ = NetFaces::kNoShell;
  std::uint64_t excess_ = 0;
  std::uint64_t area_ = 0;
};

class VolumeKeeper {
 public:
  // `fixed`: of each point, the axes along which it does not move. `is_still`: all 0.
  VolumeKeeper(const NetFaces& faces, const Buffer<std::uint8_t>& fixed, const glm::dmat3& output_from_index,
               Buffer<std::uint8_t>& is_still, Buffer<glm::vec3>& normals, Buffer<glm::vec3>& offsets)
      : faces_(faces),
        fixed_(fixed),
        output_area_(glm::inverseTranspose(output_from_index)),
        is_stretched_(is_stretched(output_from_index)),
        is_still_(is_still),
        normals_(normals),
        offsets_(offsets),
        shells_(faces.shells()),
        settled_faces_(blocks_of(faces.faces().size())),
        still_points_(blocks_of(offsets.size())) {}

  Result<void> run(const NetGrid& grid, const Context& context) {
    measure_voxels(grid);
    for (int pass = 0; pass < kMostPasses; ++pass) {
      TRY(context.check());
      const bool measures_all = std::ranges::none_of(shells_, &Shell::is_settled);
      measure_excess();
      if (choose_steps()) {
        move_points();
      } else if (measures_all) {
        break;
      } else {
        // Moves for one shell may have changed another that was right before.
        for (Shell& shell : shells_) shell.is_settled = shell.was_right = false;
        std::fill(is_still_.begin(), is_still_.end(), std::uint8_t{0});
        std::ranges::fill(settled_faces_, std::uint8_t{0});
        std::ranges::fill(still_points_, std::uint8_t{0});
      }
    }
    return {};
  }

 private:
  // Returns whether the map changes the ratio of lengths.
  static bool is_stretched(const glm::dmat3& map) {
    const glm::dmat3 squares = glm::transpose(map) * map;
    const double scale = squares[0][0];
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) {
        if (std::abs(squares[column][row] - (row == column ? scale : 0)) > 1e-9 * scale) return true;
      }
    }
    return false;
  }

  struct Size {
    glm::dvec3 area;  // as a normal
    double volume;    // between the voxel face and the two triangles that the mesh will have
  };

  [[nodiscard]] Size size_of(std::size_t number) const {
    const NetFaces::Face& face = faces_.faces()[number];
    const int up = faces_.axis(number);
    Corners offsets;
    Corners moved;
    for (std::size_t n = 0; n < 4; ++n) {
      offsets[n] = glm::dvec3(offsets_[face.points[n]]);
      moved[n] = kCorners[static_cast<std::size_t>(up)][n] + offsets[n];
    }
    const glm::dvec3 a = moved[1] - moved[0];
    const glm::dvec3 b = moved[2] - moved[0];
    const glm::dvec3 c = moved[3] - moved[0];
    // Twice the areas of the triangles around the corners.
    const std::array<glm::dvec3, 4> around{glm::cross(a, c), glm::cross(a, b), glm::cross(b - a, c - a),
                                           glm::cross(b, c)};
    const glm::dvec3 area = 0.5 * (around[1] + around[3]);
    const auto size = [&](std::size_t corner) {
      const glm::dvec3 output = is_stretched_ ? output_area_ * around[corner] : around[corner];
      return glm::dot(output, output);
    };
    // The rule of OutlinePolygon::write_bent().
    const bool is_through_apex = std::min(size(0), size(2)) < std::min(size(1), size(3));
    // The volume is the sum of area, as seen from above, times mean height of the triangles. The voxel face has height
    // 0.
    const auto height = [&](std::size_t corner) { return offsets[corner][up]; };
    const auto below = [&](std::size_t triangle, std::size_t p, std::size_t q, std::size_t r) {
      return around[triangle][up] * (height(p) + height(q) + height(r));
    };
    const double top = is_through_apex ? below(1, 0, 1, 2) + below(3, 0, 2, 3) : below(0, 0, 1, 3) + below(2, 1, 2, 3);
    return {area, top / 6 + walls_of(offsets, up) / 12};
  }

  // Returns 12 times the volume below the walls between the sides of a voxel face and those of its moved corners. A
  // wall is the mean of its two divisions into triangles. Neighbors have the same walls with the opposite sign.
  [[nodiscard]] static double walls_of(const Corners& offsets, int up) {
    const int u = (up + 1) % 3;
    const int v = (up + 2) % 3;
    double walls = 0;
    for (std::size_t n = 0; n < 4; ++n) {
      const glm::dvec3& here = offsets[n];
      const glm::dvec3& next = offsets[(n + 1) % 4];
      // The sides of the voxel face are +u, +v, -u and -v. The cross product of a side with an offset:
      const int other = n % 2 == 0 ? v : u;
      const double sign = n == 0 || n == 3 ? 1 : -1;
      const double at_here = sign * here[other];
      const double at_next = sign * next[other];
      const double between = next[u] * here[v] - next[v] * here[u];
      walls += next[up] * at_next + here[up] * at_here + (next[up] + here[up]) * (at_here + at_next + 2 * between);
    }
    return walls;
  }

  void measure_voxels(const NetGrid& grid) {
    for_each_index(grid.origins().size(), [&](std::size_t c) {
      ShellSums below(shells_);
      ShellSums above(shells_);
      faces_.for_each_of_chunk(grid, c, [&](std::size_t number, const glm::ivec3& corner) {
        if (faces_.axis(number) != 0) return;  // the faces across one axis tell the volume
        const NetFaces::Face& face = faces_.faces()[number];
        const auto volume = static_cast<std::uint64_t>(std::int64_t{corner.x});
        below.add(face.shells[0], volume, 0);
        above.add(face.shells[1], ~volume + 1, 0);
      });
    });
    for (Shell& shell : shells_) shell.voxels = static_cast<double>(static_cast<std::int64_t>(shell.excess));
  }

  void measure_excess() {
    for (Shell& shell : shells_) {
      if (!shell.is_settled) shell.excess = shell.area = 0;
    }
    for_each_index(settled_faces_.size(), [&](std::size_t block) {
      if (settled_faces_[block] != 0) return;
      ShellSums below(shells_);
      ShellSums above(shells_);
      bool any = false;
      const std::size_t end = std::min((block + 1) * kPerBlock, faces_.faces().size());
      for (std::size_t number = block * kPerBlock; number != end; ++number) {
        any |= measure_face(number, below, above);
      }
      settled_faces_[block] = any ? 0 : 1;
    });
  }

  // Adds the sizes of a face to the sums of the shells on its lower and upper sides, and sets its normal. Returns false
  // and does nothing if both are settled.
  bool measure_face(std::size_t number, ShellSums& below, ShellSums& above) {
    const NetFaces::Face& face = faces_.faces()[number];
    const std::array<bool, 2> asked{is_open(face.shells[0]), is_open(face.shells[1])};
    if (!asked[0] && !asked[1]) return false;
    const Size found = size_of(number);
    const double area = glm::length(found.area);
    const std::uint64_t units = to_units(found.volume);
    const std::uint64_t size = to_units(area);
    if (asked[0]) below.add(face.shells[0], units, size);
    if (asked[1]) above.add(face.shells[1], ~units + 1, size);
    normals_[number] = size > 0 ? found.area / area : glm::dvec3(0);
    return true;
  }

  // Returns whether a shell has to become right.
  [[nodiscard]] bool is_open(std::uint32_t shell) const {
    return shell != NetFaces::kNoShell && !shells_[shell].is_settled;
  }

  // Returns whether any shell needs a step, which is 0 for the others.
  bool choose_steps() {
    bool any = false;
    for (Shell& shell : shells_) {
      if (shell.is_settled) continue;
      const double excess = from_units(shell.excess);
      const double area = from_units(shell.area);
      if (shell.wanted != 0) {
        const double got = excess - shell.before;
        const double ratio = got * shell.wanted > 0 ? shell.wanted / got : kMostGain;
        shell.gain = std::clamp(shell.gain * std::clamp(ratio, 0.5, 2.0), kLeastGain, kMostGain);
      }
      shell.before = excess;
      shell.wanted = 0;
      shell.step = 0;
      const bool is_right = shell.is_right();
      shell.is_settled = is_right && shell.was_right;
      shell.was_right = is_right;
      if (is_right) continue;
      any = true;
      shell.wanted = -excess;
      shell.step = static_cast<float>(std::clamp(-shell.gain * excess / area, -1.0, 1.0));
    }
    return any;
  }

  void move_points() {
    for_each_index(still_points_.size(), [&](std::size_t block) {
      if (still_points_[block] != 0) return;
      bool all_still = true;
      const std::size_t end = std::min((block + 1) * kPerBlock, offsets_.size());
      for (std::size_t k = block * kPerBlock; k != end; ++k) {
        if (is_still_[k] == 0) move_point(k);
        all_still &= is_still_[k] != 0;
      }
      still_points_[block] = all_still ? 1 : 0;
    });
  }

  void move_point(std::size_t k) {
    glm::vec3 way(0);
    const auto around = faces_.around(static_cast<std::uint32_t>(k));
    bool is_still = true;
    for (const std::uint32_t number : around) {
      const NetFaces::Face& face = faces_.faces()[number];
      is_still = is_still && !is_open(face.shells[0]) && !is_open(face.shells[1]);
      way += step_of(face) * normals_[number];
    }
    is_still_[k] = is_still ? 1 : 0;
    if (way == glm::vec3(0)) return;
    way /= static_cast<float>(around.size());
    way *= std::min(1.0F, kLongestStep / glm::length(way));
    offsets_[k] = offset_within_cell(offsets_[k] + way, fixed_[k]);
  }

  // Returns how far a face moves toward its upper side.
  [[nodiscard]] float step_of(const NetFaces::Face& face) const {
    const auto outward = [&](std::uint32_t shell) { return shell == NetFaces::kNoShell ? 0 : shells_[shell].step; };
    const bool is_shared = face.shells[0] != NetFaces::kNoShell && face.shells[1] != NetFaces::kNoShell;
    return (is_shared ? 0.5F : 1.0F) * (outward(face.shells[0]) - outward(face.shells[1]));
  }

  const NetFaces& faces_;
  const Buffer<std::uint8_t>& fixed_;
  glm::dmat3 output_area_;  // maps areas, but for a factor
  bool is_stretched_;
  Buffer<std::uint8_t>& is_still_;  // of the points: all shells around it are settled
  Buffer<glm::vec3>& normals_;      // of the faces, of length 1
  Buffer<glm::vec3>& offsets_;
  std::vector<Shell> shells_;
  std::vector<std::uint8_t> settled_faces_;  // of the blocks of faces: all shells are settled
  std::vector<std::uint8_t> still_points_;   // of the blocks of points: all are still
};

}  // namespace

Result<void> keep_volumes(const NetGrid& grid, const LabelChunks& labels, const glm::dmat3& output_from_index,
                          Buffer<glm::vec3>& offsets, const Context& context, const std::string& what) {
  const NetFaces faces = TRY(NetFaces::make(grid, labels, context, what));
  auto fixed = TRY(make_reserved_buffer<std::uint8_t>(grid.size(), context, what));
  auto normals = TRY(make_reserved_buffer<glm::vec3>(faces.faces().size(), context, what));
  auto is_still = TRY(make_reserved_buffer<std::uint8_t>(grid.size(), context, what));
  std::fill(is_still->values.begin(), is_still->values.end(), std::uint8_t{0});
  const auto shells = TRY(context.reserve(faces.shells() * sizeof(Shell), what));
  for_each_index(grid.origins().size(), [&](std::size_t c) {
    grid.for_each_row(c, [&](const NetGrid::Row& row, int y, int z) {
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) {
        const glm::ivec3 corner = grid.origins()[c] + glm::ivec3(bit, y, z);
        fixed->values[k++] = static_cast<std::uint8_t>(fixed_axes(corner, labels.bounds()));
      });
    });
  });
  return VolumeKeeper(faces, fixed->values, output_from_index, is_still->values, normals->values, offsets)
      .run(grid, context);
}

}  // namespace isoextract::extract

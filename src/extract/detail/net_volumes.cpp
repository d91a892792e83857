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
constexpr std::size_t kFacesPerTask = 1 << 12;

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
  VolumeKeeper(const NetFaces& faces, const Buffer<glm::ivec3>& corners, const field::IndexBox& bounds,
               const glm::dmat3& output_from_index, Buffer<std::uint8_t>& is_still, Buffer<glm::vec3>& normals,
               Buffer<glm::vec3>& offsets)
      : faces_(faces),
        corners_(corners),
        bounds_(bounds),
        output_area_(glm::inverseTranspose(output_from_index)),
        is_stretched_(is_stretched(output_from_index)),
        is_still_(is_still),
        normals_(normals),
        offsets_(offsets),
        shells_(faces.shells()) {}

  Result<void> run(const Context& context) {
    measure_voxels();
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

  [[nodiscard]] Size size_of(const NetFaces::Face& face) const {
    std::array<glm::dvec3, 4> still;  // the corners of the voxel face, from the first one
    std::array<glm::dvec3, 4> moved;
    for (std::size_t n = 0; n < 4; ++n) {
      still[n] = glm::dvec3(corners_[face.points[n]] - corners_[face.points[0]]);
      moved[n] = still[n] + glm::dvec3(offsets_[face.points[n]]);
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
    // The rule of OutlinePolygon::write_bent(). The diagonals differ in volume by a tetrahedron.
    const bool is_through_apex = std::min(size(0), size(2)) < std::min(size(1), size(3));
    const double tetrahedron = is_through_apex ? 0 : glm::dot(a, around[3]) / 6;
    // The walls between the sides of both faces. Neighbors have the same walls with the opposite sign.
    const auto triple = [](const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r) {
      return glm::dot(p, glm::cross(q, r));
    };
    double walls = 0;
    for (std::size_t n = 0; n < 4; ++n) {
      const std::size_t next = (n + 1) % 4;
      walls += triple(still[n], still[next], moved[next]) + triple(still[n], moved[next], moved[n]) +
               triple(still[next], moved[next], moved[n]) + triple(still[next], moved[n], still[n]);
    }
    return {area, glm::dot(moved[0], area) / 3 + tetrahedron + walls / 12};
  }

  // Calls f(number, below, above) for all faces, with the sums of the shells on their lower and upper sides.
  template <class F>
  void for_each_face(const F& f) {
    for_each_range(faces_.faces().size(), kFacesPerTask, [&](std::size_t begin, std::size_t end) {
      ShellSums below(shells_);
      ShellSums above(shells_);
      for (std::size_t n = begin; n != end; ++n) f(n, below, above);
    });
  }

  [[nodiscard]] int axis_of(const NetFaces::Face& face) const {
    const glm::ivec3 diagonal = corners_[face.points[2]] - corners_[face.points[0]];
    return diagonal.x == 0 ? 0 : diagonal.y == 0 ? 1 : 2;
  }

  void measure_voxels() {
    for_each_face([&](std::size_t number, ShellSums& below, ShellSums& above) {
      const NetFaces::Face& face = faces_.faces()[number];
      if (axis_of(face) != 0) return;  // the faces across one axis tell the volume
      const auto volume = static_cast<std::uint64_t>(std::int64_t{corners_[face.points[0]].x});
      below.add(face.shells[0], volume, 0);
      above.add(face.shells[1], ~volume + 1, 0);
    });
    for (Shell& shell : shells_) shell.voxels = static_cast<double>(static_cast<std::int64_t>(shell.excess));
  }

  void measure_excess() {
    for (Shell& shell : shells_) {
      if (!shell.is_settled) shell.excess = shell.area = 0;
    }
    for_each_face([&](std::size_t number, ShellSums& below, ShellSums& above) {
      const NetFaces::Face& face = faces_.faces()[number];
      const std::array<bool, 2> asked{is_open(face.shells[0]), is_open(face.shells[1])};
      if (!asked[0] && !asked[1]) return;
      const Size found = size_of(face);
      const std::uint64_t units = to_units(found.volume);
      const std::uint64_t size = to_units(glm::length(found.area));
      if (asked[0]) below.add(face.shells[0], units, size);
      if (asked[1]) above.add(face.shells[1], ~units + 1, size);
      normals_[number] = size > 0 ? found.area / glm::length(found.area) : glm::dvec3(0);
    });
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
    for_each_index(
        offsets_.size(),
        [&](std::size_t k) {
          if (is_still_[k] != 0) return;
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
          offsets_[k] = offset_within_cell(offsets_[k] + way, fixed_axes(corners_[k], bounds_));
        },
        kFacesPerTask);
  }

  // Returns how far a face moves toward its upper side.
  [[nodiscard]] float step_of(const NetFaces::Face& face) const {
    const auto outward = [&](std::uint32_t shell) { return shell == NetFaces::kNoShell ? 0 : shells_[shell].step; };
    const bool is_shared = face.shells[0] != NetFaces::kNoShell && face.shells[1] != NetFaces::kNoShell;
    return (is_shared ? 0.5F : 1.0F) * (outward(face.shells[0]) - outward(face.shells[1]));
  }

  const NetFaces& faces_;
  const Buffer<glm::ivec3>& corners_;
  const field::IndexBox& bounds_;
  glm::dmat3 output_area_;  // maps areas, but for a factor
  bool is_stretched_;
  Buffer<std::uint8_t>& is_still_;  // of the points: all shells around it are settled
  Buffer<glm::vec3>& normals_;      // of the faces, of length 1
  Buffer<glm::vec3>& offsets_;
  std::vector<Shell> shells_;
};

}  // namespace

Result<void> keep_volumes(const NetGrid& grid, const LabelChunks& labels, const glm::dmat3& output_from_index,
                          Buffer<glm::vec3>& offsets, const Context& context, const std::string& what) {
  const NetFaces faces = TRY(NetFaces::make(grid, labels, context, what));
  auto corners = TRY(make_reserved_buffer<glm::ivec3>(grid.size(), context, what));
  auto normals = TRY(make_reserved_buffer<glm::vec3>(faces.faces().size(), context, what));
  auto is_still = TRY(make_reserved_buffer<std::uint8_t>(grid.size(), context, what));
  std::fill(is_still->values.begin(), is_still->values.end(), std::uint8_t{0});
  const auto shells = TRY(context.reserve(faces.shells() * sizeof(Shell), what));
  for_each_index(grid.origins().size(), [&](std::size_t c) {
    grid.for_each_row(c, [&](const NetGrid::Row& row, int y, int z) {
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) { corners->values[k++] = grid.origins()[c] + glm::ivec3(bit, y, z); });
    });
  });
  return VolumeKeeper(faces, corners->values, labels.bounds(), output_from_index, is_still->values, normals->values,
                      offsets)
      .run(context);
}

}  // namespace isoextract::extract

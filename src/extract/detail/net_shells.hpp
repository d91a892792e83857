// The sums over the shells of a surface net that keep_volumes() needs: volumes, areas, common areas, and steps.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "extract/detail/net_faces.hpp"
#include "extract/detail/net_volumes.hpp"
#include "extract/detail/reserved_list.hpp"

namespace isoextract::extract {

// Volumes and areas are sums of integers, so that the order of the threads does not change them. Sums may wrap around
// on the way; only their final value must fit.
inline constexpr double kUnits = 1 << 24;  // per grid step cubed
[[nodiscard]] inline std::uint64_t to_units(double value) {
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(value * kUnits));
}
[[nodiscard]] inline double from_units(std::uint64_t sum) {
  return static_cast<double>(static_cast<std::int64_t>(sum)) / kUnits;
}

struct Shell {
  std::uint64_t excess = 0;  // volume of the net minus volume of the voxels
  std::uint64_t area = 0;
  double voxels = 0;  // volume; negative for a cavity
  double before = 0;  // the excess before the last move
  double wanted = 0;  // the change of volume for which the step was chosen
  double gain = 1;    // corrects steps by the change of volume that the last one achieved

  [[nodiscard]] bool is_right() const { return std::abs(from_units(excess)) <= kNetVolumeTolerance * std::abs(voxels); }
};

// How far each shell moves outward, in grid steps. Kept apart from the other facts, so that all steps fit into the
// fastest cache.
class ShellSteps {
 public:
  explicit ShellSteps(std::size_t shells) : steps_(shells + 1, 0.0F) {}

  static constexpr std::uint64_t kBytesPerShell = sizeof(float);

  void set(std::size_t shell, double step) { steps_[shell] = static_cast<float>(std::clamp(step, -1.0, 1.0)); }
  // Returns 0 for kNoShell.
  [[nodiscard]] float operator[](std::uint32_t shell) const {
    return steps_[std::min<std::size_t>(shell, steps_.size() - 1)];
  }

  // Returns how far a face moves toward its upper side.
  [[nodiscard]] float of_face(const NetFaces::Shells& shells) const {
    const bool is_shared = shells[0] != NetFaces::kNoShell && shells[1] != NetFaces::kNoShell;
    return (is_shared ? 0.5F : 1.0F) * ((*this)[shells[0]] - (*this)[shells[1]]);
  }

 private:
  std::vector<float> steps_;  // then 0
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
    std::uint32_t area;  // the part that can move, in kAreaUnits
  };

  // Bytes besides the links.
  static constexpr std::uint64_t kBytesPerShell = 5 * sizeof(double);
  static constexpr std::uint64_t kBytesPerChunk = sizeof(ReservedList<Link>);
  // Bytes of the links of a chunk, at least; the lists reserve them.
  static constexpr std::uint64_t kLeastListBytes = ReservedList<Link>::kLeastCapacity * sizeof(Link);

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
  [[nodiscard]] bool any_step(std::size_t chunk, const ShellSteps& steps) const {
    return std::ranges::any_of(of_chunks_[chunk].values(), [&](const Link& link) {
      return steps[link.shells[0]] != 0 || steps[link.shells[1]] != 0;
    });
  }

  // Chooses steps that together change all volumes as wanted, if no cell limits them. The change is a linear function
  // of the steps, with a symmetric matrix. Scaled by its diagonal, the matrix has eigenvalues from 0 to 2:
  // Chebyshev's iteration needs nothing else. Sums are of integers, so they depend neither on the order of the shells
  // nor on the chunks.
  void solve(const std::vector<Shell>& shells, ShellSteps& chosen) const;

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

}  // namespace isoextract::extract

#include "extract/detail/net_volumes.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "extract/detail/corner_words.hpp"
#include "extract/detail/net_face_size.hpp"
#include "extract/detail/net_faces.hpp"
#include "extract/detail/net_relaxation.hpp"
#include "extract/detail/net_shells.hpp"
#include "extract/detail/voxel_input.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {
namespace {

constexpr int kMostPasses = 40;
constexpr int kCoupledPasses = 2;      // choose the steps of all shells together
constexpr float kLongestStep = 0.25F;  // of a point in one pass, in grid steps
constexpr double kLeastGain = 0.5;
constexpr double kMostGain = 4;
constexpr double kMostSearched = 0.2;  // the greatest share of the area whose faces a pass searches for

class VolumeKeeper {
 public:
  VolumeKeeper(const NetGrid& grid, const NetFaces& faces, const field::IndexBox& bounds,
               const glm::dmat3& output_from_index, NetArray<glm::vec3>& offsets, NetMemory& memory)
      : memory_(memory),
        grid_(grid),
        faces_(faces),
        bounds_(bounds),
        sizes_(offsets, output_from_index),
        offsets_(offsets),
        shells_(faces.shells()),
        steps_(faces.shells()),
        has_steps_(grid.origins().size()),
        is_marked_(grid.origins().size()) {}

  // Returns the bytes that a keeper takes in addition to the constructor's arguments and the arrays of run().
  static std::uint64_t list_bytes(std::uint64_t shells, std::uint64_t chunks) {
    return shells * (sizeof(Shell) + ShellSteps::kBytesPerShell + ShellLinks::kBytesPerShell) +
           chunks * (ShellLinks::kBytesPerChunk + 2);
  }
  // Returns the bytes of the arrays of run().
  static std::uint64_t array_bytes(std::uint64_t faces, std::uint64_t chunks) {
    return faces * sizeof(glm::vec3) + chunks * sizeof(ChunkBits);
  }

  Result<void> run() {
    const Context& context = memory_.context();
    areas_ = TRY(memory_.make<glm::vec3>(faces_.size()));
    moving_ = TRY(memory_.make<ChunkBits>(grid_.origins().size()));
    measure_voxels();
    measure_all();
    const ShellLinks links = TRY(link_shells());
    for (int pass = 0; pass < kMostPasses; ++pass) {
      TRY(context.check());
      if (!choose_changes()) break;
      if (pass < kCoupledPasses) {
        links.solve(shells_, steps_);
      } else {
        choose_steps_alone();
      }
      // Adding all faces to the sums once is less work than to find many of them, subtract and add them.
      if (moving_share() > kMostSearched) {
        move_points([](std::size_t, std::size_t) { return ~std::uint64_t{0}; });
        measure_all();
      } else {
        memory_.for_each_chunk(grid_.origins().size(),
                               [&](std::size_t c) { has_steps_[c] = links.any_step(c, steps_) ? 1 : 0; });
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
    memory_.for_each_chunk(grid_.origins().size(), [&](std::size_t c) {
      ShellSums sums(shells_);
      faces_.for_each_of_chunk(grid_, c, [&](std::size_t number, int axis, const glm::ivec3& corner) {
        if (axis != 0) return;  // the faces across one axis tell the volume
        sums.add(faces_.shells_of(number), to_units(grid_.origins()[c].x + corner.x), 0);
      });
    });
    for (Shell& shell : shells_) shell.voxels = from_units(std::exchange(shell.excess, 0));
  }

  // Sums the areas that shells have in common.
  Result<ShellLinks> link_shells() {
    ShellLinks links(grid_.origins().size(), memory_.context(), memory_.what());
    memory_.for_each_chunk(grid_.origins().size(), [&](std::size_t c) {
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
    memory_.for_each_chunk(grid_.origins().size(),
                           [&](std::size_t c) { add_faces(c, 1, [](std::size_t) { return ~std::uint64_t{0}; }); });
  }

  // Adds the faces of a chunk whose first point is in which(row) to the sums of their shells, times `sign`.
  template <class Which>
  void add_faces(std::size_t chunk, int sign, const Which& which) {
    std::optional<NearPoints> near;  // made if a face is found
    ShellSums sums(shells_);
    const auto factor = static_cast<std::uint64_t>(std::int64_t{sign});
    grid_.for_each_row(chunk, [&](const NetGrid::Row& row, int y, int z) {
      const std::uint64_t asked = which(chunk_row(y, z));
      if ((asked & row.used) == 0) return;
      if (!near) near.emplace(grid_, chunk);
      std::uint32_t number = faces_.first_of_row(chunk, chunk_row(y, z));
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) {
        const unsigned axes = faces_.own_axes(k++);
        if ((asked >> bit & 1) == 0) {
          number += static_cast<std::uint32_t>(count_bits(axes));
          return;
        }
        for_each_bit(axes, [&](int axis) {
          const NetFaceSize size = sizes_.of(*near, NearPlaces::of(bit, y, z), axis);
          areas_[number] = size.area;
          sums.add(faces_.shells_of(number), factor * to_units(size.volume), factor * to_units(glm::length(size.area)));
          ++number;
        });
      });
    });
  }

  // Returns the area of the shells that make a step, as a part of the area of all shells.
  [[nodiscard]] double moving_share() const {
    double moving = 0;
    double all = 0;
    for (std::uint32_t s = 0; s < shells_.size(); ++s) {
      const double area = from_units(shells_[s].area);
      all += area;
      if (steps_[s] != 0) moving += area;
    }
    return all > 0 ? moving / all : 0;
  }

  // Marks the points of faces that make a step.
  void mark_moving() {
    std::ranges::fill(is_marked_, std::uint8_t{0});
    // Clears the bits of all chunks that may get marked points, before any thread sets bits.
    memory_.for_each_run(has_steps_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c) {
        if (has_steps_[c] == 0) continue;
        for (unsigned n = 0; n < 8; ++n) {
          const std::int32_t up = upper(c, n);
          if (up < 0 || std::exchange(is_marked_[static_cast<std::size_t>(up)], std::uint8_t{1}) != 0) continue;
          moving_[static_cast<std::size_t>(up)].fill(0);
        }
      }
    });
    memory_.for_each_chunk(grid_.origins().size(), [&](std::size_t c) {
      if (has_steps_[c] == 0) return;
      faces_.for_each_of_chunk(grid_, c, [&](std::size_t number, int axis, const glm::ivec3& corner) {
        if (steps_.of_face(faces_.shells_of(number)) == 0) return;
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
    memory_.for_each_chunk(grid_.origins().size(), [&](std::size_t c) {
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
    for (std::size_t s = 0; s < shells_.size(); ++s) {
      const Shell& shell = shells_[s];
      const double area = from_units(shell.area);
      steps_.set(s, area > 0 ? shell.gain * shell.wanted / area : 0);
    }
  }

  // Moves the points in which(chunk, row) by the steps of the faces around them.
  template <class Which>
  void move_points(const Which& which) {
    memory_.for_each_chunk(grid_.origins().size(), [&](std::size_t c) {
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
      const float step = steps_.of_face(faces_.shells_of(number));
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

  NetMemory& memory_;
  const NetGrid& grid_;
  const NetFaces& faces_;
  field::IndexBox bounds_;
  NetFaceSizes sizes_;
  NetArray<glm::vec3> areas_;  // of the faces, as area vectors
  NetArray<glm::vec3>& offsets_;
  std::vector<Shell> shells_;
  ShellSteps steps_;
  std::vector<std::uint8_t> has_steps_;  // of each chunk: any of its shells makes a step
  std::vector<std::uint8_t> is_marked_;  // of each chunk: moving_ is valid, and may have points
  NetArray<ChunkBits> moving_;           // the points that the pass moves
};

}  // namespace

Result<std::vector<LabelShells>> keep_volumes(const NetGrid& grid, const LabelChunks& labels,
                                              const glm::dmat3& output_from_index, NetArray<glm::vec3>& offsets,
                                              NetMemory& memory) {
  const NetFaces faces = TRY(NetFaces::make(grid, labels, memory));
  const auto held =
      TRY(memory.context().reserve(VolumeKeeper::list_bytes(faces.shells(), grid.origins().size()), memory.what()));
  TRY(VolumeKeeper(grid, faces, labels.bounds(), output_from_index, offsets, memory).run());
  return faces.count_shells(grid, labels);
}

std::uint64_t volume_keeping_bytes(std::uint64_t points, std::uint64_t faces, std::uint64_t chunks) {
  return NetFaces::bytes(points, faces, chunks) + VolumeKeeper::array_bytes(faces, chunks) + volume_list_bytes(chunks);
}

std::uint64_t volume_list_bytes(std::uint64_t chunks) {
  return VolumeKeeper::list_bytes(0, chunks) + chunks * ShellLinks::kLeastListBytes;
}

}  // namespace isoextract::extract

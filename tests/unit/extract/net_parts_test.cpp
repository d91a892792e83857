// The parts of surface nets beside plain versions of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "extract/detail/net_faces.hpp"
#include "extract/detail/net_grid.hpp"
#include "extract/detail/net_relaxation.hpp"
#include "mesh/components.hpp"
#include "support/voxel_patterns.hpp"
#include "unit/extract/label_nets.hpp"

namespace isoextract::extract::net_parts {
namespace {

const glm::ivec3 kDims(70, 11, 10);  // more than one chunk along each axis

// Labels 1 and 2 in the voxels of kDims; 0: no label.
class Map {
 public:
  Map(unsigned seed, int blocks) {
    std::mt19937 engine(seed);
    std::map<std::tuple<int, int, int>, int> of_block;
    for (int z = 0; z < kDims.z; ++z) {
      for (int y = 0; y < kDims.y; ++y) {
        for (int x = 0; x < kDims.x; ++x) {
          const auto [at, is_new] = of_block.try_emplace({x / blocks, y / blocks, z / blocks}, 0);
          if (is_new) at->second = static_cast<int>(engine() % 3);
          labels_.push_back(at->second);
        }
      }
    }
  }

  // Returns -1 beyond the data boundary.
  [[nodiscard]] int at(const glm::ivec3& p) const {
    const bool there = glm::all(glm::greaterThanEqual(p, glm::ivec3(0))) && glm::all(glm::lessThan(p, kDims));
    return there ? labels_[static_cast<std::size_t>(p.x + kDims.x * (p.y + kDims.y * p.z))] : -1;
  }

  [[nodiscard]] LabelChunks chunks() {
    std::map<std::tuple<int, int, int, int>, ChunkBits> found;
    for (int z = 0; z < kDims.z; ++z) {
      for (int y = 0; y < kDims.y; ++y) {
        for (int x = 0; x < kDims.x; ++x) {
          if (at({x, y, z}) == 0) continue;
          const glm::ivec3 origin = chunk_origin({x, y, z});
          found[{origin.z, origin.y, origin.x, at({x, y, z})}][chunk_row(y, z)] |= std::uint64_t{1} << (x & 63);
        }
      }
    }
    std::vector<LabelChunk> list;
    for (const auto& [key, bits] : found) {
      const auto& [z, y, x, label] = key;
      bits_.push_back(std::make_unique<ChunkBits>(bits));
      list.push_back({label, {x, y, z}, bits_.back().get(), rows_with_voxels(bits)});
    }
    return {std::move(list), nullptr, {glm::ivec3(0), kDims - 1}, Reservation()};
  }

  [[nodiscard]] field::ScalarField field() const {
    return test::dense_field<std::uint8_t>(kDims, [&](int x, int y, int z) { return at({x, y, z}); });
  }

 private:
  std::vector<int> labels_;
  std::vector<std::unique_ptr<ChunkBits>> bits_;
};

using Corner = std::tuple<int, int, int>;
Corner key(const glm::ivec3& p) { return {p.z, p.y, p.x}; }

struct PlainPoint {
  glm::ivec3 corner;
  std::vector<glm::ivec3> connected;  // steps to the connected points
  glm::vec3 start{0};
  glm::vec3 half{0};
  glm::vec3 end{0};
};

std::map<Corner, PlainPoint> plain_points(const Map& map) {
  std::map<Corner, PlainPoint> points;
  for (int z = 0; z <= kDims.z; ++z) {
    for (int y = 0; y <= kDims.y; ++y) {
      for (int x = 0; x <= kDims.x; ++x) {
        const glm::ivec3 corner(x, y, z);
        std::set<int> around;  // a point needs two, where voxels without a label and those beyond the data are one
        std::map<int, std::vector<glm::ivec3>> steps;  // by the least number of labels, where they are two
        for (int axis = 0; axis < 3; ++axis) {
          for (int side = 0; side < 2; ++side) {
            std::set<int> labels;
            for (int n = 0; n < 4; ++n) {
              glm::ivec3 voxel = corner - 1;
              voxel[axis] += side;
              voxel[(axis + 1) % 3] += n & 1;
              voxel[(axis + 2) % 3] += n >> 1;
              labels.insert(map.at(voxel));
              around.insert(std::max(map.at(voxel), 0));
            }
            glm::ivec3 step(0);
            step[axis] = side == 1 ? 1 : -1;
            if (labels.size() >= 2) steps[2].push_back(step);
            if (labels.size() >= 3) steps[3].push_back(step);
          }
        }
        if (around.size() >= 2) points[key(corner)] = {corner, steps[3].size() >= 2 ? steps[3] : steps[2]};
      }
    }
  }
  return points;
}

// Taubin's rounds with momentum, point by point.
void relax(std::map<Corner, PlainPoint>& points, int rounds) {
  const auto mean = [&](const PlainPoint& point, auto member) {
    glm::vec3 sum(0);
    for (const glm::ivec3& step : point.connected) {
      sum += glm::vec3(step) + points.at(key(point.corner + step)).*member;
    }
    return sum / static_cast<float>(point.connected.size());
  };
  const auto held = [](const PlainPoint& point, glm::vec3 offset) {
    for (int axis = 0; axis < 3; ++axis) {
      if (point.corner[axis] == 0 || point.corner[axis] == kDims[axis]) offset[axis] = 0;
    }
    return offset;
  };
  float theta = 1;
  for (int round = 0; round < rounds; ++round) {
    const float next = (1 + std::sqrt(1 + 4 * theta * theta)) / 2;
    for (auto& [corner, point] : points) {
      point.half = held(point, 0.5F * (point.start + mean(point, &PlainPoint::start)));
    }
    for (auto& [corner, point] : points) {
      const glm::vec3 back = point.half - 0.5F * (mean(point, &PlainPoint::half) - point.half);
      const glm::vec3 end = held(point, glm::clamp(back, -0.48F, 0.48F));
      point.start = end + (theta - 1) / next * (end - point.end) + theta / next * (end - point.start);
      point.end = end;
    }
    theta = next;
  }
}

// Calls f(number, corner) for the points of a grid.
template <class F>
void for_each_point(const NetGrid& grid, const F& f) {
  for (std::size_t c = 0; c < grid.origins().size(); ++c) {
    grid.for_each_row(c, [&](const NetGrid::Row& row, int y, int z) {
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) { f(k++, grid.origins()[c] + glm::ivec3(bit, y, z)); });
    });
  }
}

TEST(NetParts, RelaxesLikePlainLoop) {
  for (const int blocks : {1, 4}) {
    Map map(3, blocks);
    const LabelChunks labels = map.chunks();
    NetMemory memory(Context(), "test");
    const auto grid = NetGrid::make(labels, memory);
    ASSERT_TRUE(grid);
    auto made = memory.make<glm::vec3>(grid->size() + 1);
    ASSERT_TRUE(made);
    NetArray<glm::vec3>& offsets = *made;
    memory.fill(offsets, glm::vec3(0));
    ASSERT_TRUE(relax_net(*grid, labels, 5, offsets, memory));
    std::map<Corner, PlainPoint> plain = plain_points(map);
    relax(plain, 5);
    ASSERT_EQ(grid->size(), plain.size());
    float farthest = 0;
    for_each_point(*grid, [&](std::uint32_t k, const glm::ivec3& corner) {
      ASSERT_TRUE(plain.contains(key(corner)));
      const glm::vec3 away = glm::abs(offsets[k] - plain.at(key(corner)).end);
      EXPECT_LT(std::max({away.x, away.y, away.z}), 1e-5F);
      farthest = std::max(farthest, glm::length(offsets[k]));
    });
    EXPECT_GT(farthest, 0.3F);
  }
}

TEST(NetParts, FindsFacesThatContainEachPoint) {
  Map map(4, 2);
  const LabelChunks labels = map.chunks();
  NetMemory memory(Context(), "test");
  const auto grid = NetGrid::make(labels, memory);
  ASSERT_TRUE(grid);
  const auto faces = NetFaces::make(*grid, labels, memory);
  ASSERT_TRUE(faces);
  std::vector<std::set<std::uint32_t>> points(faces->size());
  for (std::size_t c = 0; c < grid->origins().size(); ++c) {
    const NearPoints near(*grid, c);
    faces->for_each_of_chunk(*grid, c, [&](std::size_t number, int axis, const glm::ivec3& corner) {
      for (const int step : NetFaces::kPoints[static_cast<std::size_t>(axis)]) {
        points[number].insert(near[NearPlaces::of(corner.x, corner.y, corner.z) + step]);
      }
      EXPECT_EQ(points[number].size(), 4U);
    });
  }
  std::size_t around = 0;
  for (std::size_t c = 0; c < grid->origins().size(); ++c) {
    const NearFaces near(*grid, *faces, c);
    grid->for_each_row(c, [&](const NetGrid::Row& row, int y, int z) {
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) {
        for_each_bit(faces->sides(k), [&](int side) {
          EXPECT_TRUE(points[near.number(NearPlaces::of(bit, y, z), side)].contains(k));
          ++around;
        });
        ++k;
      });
    });
  }
  EXPECT_EQ(around, 4 * faces->size());
}

// A shell is a component of the mesh of its label.
TEST(NetParts, CountsOneShellPerComponent) {
  for (const int blocks : {1, 2, 5}) {
    Map map(5, blocks);
    const LabelChunks labels = map.chunks();
    NetMemory memory(Context(), "test");
    const auto grid = NetGrid::make(labels, memory);
    ASSERT_TRUE(grid);
    const auto faces = NetFaces::make(*grid, labels, memory);
    ASSERT_TRUE(faces);
    std::size_t components = 0;
    for (const auto& [label, mesh] : nets_of(map.field(), net_options(0))) {
      components += mesh::Components(mesh.triangles.span(), mesh.positions.size()).count();
    }
    EXPECT_EQ(faces->shells(), components);
  }
}

TEST(NetParts, CountsShellsOfEachLabel) {
  for (const int blocks : {1, 2, 5, 8}) {
    SCOPED_TRACE(blocks);
    const auto any_of_three = [&](int x, int y, int z) {
      const int block = x / blocks + 100 * (y / blocks) + 10000 * (z / blocks);
      return static_cast<int>(std::mt19937(static_cast<unsigned>(block))() % 3);
    };
    const field::ScalarField dense = test::dense_field<std::uint8_t>({72, 16, 16}, any_of_three);
    for (const bool sparse : {false, true}) {
      const field::ScalarField field = sparse ? test::sparse_copy<std::uint8_t>(dense, 0) : dense;
      const auto found = LabelVoxels::find(field, net_options(1), {true, {}}, Context());
      ASSERT_TRUE(found) << found.error().message;
      const Labels meshes = nets_of(field, net_options(1));
      ASSERT_EQ(meshes.size(), 2U);
      for (const auto& [label, mesh] : meshes) {
        const mesh::Components components(mesh.triangles.span(), mesh.positions.size());
        EXPECT_EQ(found->find(label)->shells, components.count()) << label;
      }
    }
  }
  // A cavity is a shell of its own.
  const auto label = [](int x, int y, int z) {
    const bool is_in = std::min({x, y, z}) >= 2 && std::max({x, y, z}) < 9;
    return is_in && glm::ivec3(x, y, z) != glm::ivec3(5) ? 1 : 0;
  };
  const field::ScalarField hollow = test::dense_field<std::uint8_t>(glm::ivec3(11), label);
  const auto found = LabelVoxels::find(hollow, net_options(1), {true, {}}, Context());
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->find(1)->shells, 2U);
  const auto unknown = LabelVoxels::find(hollow, net_options(0), {true, {}}, Context());
  ASSERT_TRUE(unknown) << unknown.error().message;
  EXPECT_EQ(unknown->find(1)->shells, 0U);
}

}  // namespace
}  // namespace isoextract::extract::net_parts

// OpenVDB's trees as inputs, and its mesher. The only file of the benchmark that includes OpenVDB.
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/parallel_sort.h>

#include "base/stopwatch.hpp"
#include "bench/contestant.hpp"

namespace isoextract::bench {

class VdbGrid {
 public:
  explicit VdbGrid(openvdb::FloatGrid::Ptr grid) : grid_(std::move(grid)) {}
  [[nodiscard]] const openvdb::FloatGrid& operator*() const { return *grid_; }

 private:
  openvdb::FloatGrid::Ptr grid_;
};

namespace {

glm::ivec3 to_glm(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }

// Blocks that point into the tree's leaves, and the tiles that are not background.
template <class Node>
void add_node(const Node& node, field::SparseSamples& samples) {
  using Child = typename Node::ChildNodeType;
  for (auto tile = node.cbeginValueAll(); tile; ++tile) {
    if (*tile == samples.background) continue;
    samples.tiles.push_back({to_glm(tile.getCoord()), static_cast<int>(Child::DIM), *tile});
  }
  for (auto child = node.cbeginChildOn(); child; ++child) {
    if constexpr (Child::LEVEL == 0) {
      samples.blocks.push_back({to_glm(child.getCoord()), child->buffer().data()});
    } else {
      add_node(*child, samples);
    }
  }
}

field::SparseSamples sparse_samples(const openvdb::FloatTree& tree) {
  field::SparseSamples samples;
  samples.background = tree.background();
  samples.blocks.reserve(tree.leafCount());
  add_node(tree.root(), samples);
  tbb::parallel_sort(samples.blocks, [](const field::SparseBlock& a, const field::SparseBlock& b) {
    return std::tie(a.origin.x, a.origin.y, a.origin.z) < std::tie(b.origin.x, b.origin.y, b.origin.z);
  });
  samples.active_voxels = tree.activeVoxelCount();
  openvdb::CoordBBox box;
  if (tree.evalActiveVoxelBoundingBox(box)) samples.active_box = {to_glm(box.min()), to_glm(box.max())};
  return samples;
}

BenchmarkInput as_input(std::string name, int size, const openvdb::FloatGrid::Ptr& grid, field::FieldKind kind,
                        double iso) {
  BenchmarkInput input{std::move(name), size, {}, iso, std::make_shared<VdbGrid>(grid)};
  input.field.name = input.name;
  input.field.kind = kind;
  field::SparseSamples samples = sparse_samples(grid->tree());
  samples.owner = input.grid;
  input.field.samples = std::move(samples);
  return input;
}

// Voxels of size 1, and as many across the sphere as demo:sphere has of `size` samples along an axis.
openvdb::FloatGrid::Ptr sphere(int size) {
  openvdb::initialize();
  const float radius = 0.35F * static_cast<float>(size - 1);
  constexpr float kVoxelSize = 1;
  return openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(radius, openvdb::Vec3f(0), kVoxelSize);
}

Outcome outcome_of(const BenchmarkInput& input, double seconds, std::uint64_t vertices, std::uint64_t triangles,
                   std::uint64_t quads) {
  const std::uint64_t written =
      vertices * sizeof(openvdb::Vec3s) + triangles * sizeof(openvdb::Vec3I) + quads * sizeof(openvdb::Vec4I);
  return {1000 * seconds, triangles + 2 * quads, vertices, sample_bytes(input), written};
}

class OpenvdbContestant : public Contestant {
 public:
  explicit OpenvdbContestant(const BenchmarkInput& input) : input_(input) {}
  [[nodiscard]] std::string program() const override { return "OpenVDB " OPENVDB_LIBRARY_VERSION_STRING; }

 protected:
  const BenchmarkInput& input_;
};

class VolumeToMeshFunction : public OpenvdbContestant {
 public:
  using OpenvdbContestant::OpenvdbContestant;
  [[nodiscard]] std::string name() const override { return "volumeToMesh"; }

  Outcome run() override {
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    const Stopwatch watch;
    openvdb::tools::volumeToMesh(**input_.grid, points, triangles, quads, input_.iso);
    return outcome_of(input_, watch.elapsed().wall_seconds, points.size(), triangles.size(), quads.size());
  }
};

// The same without the copy into one array of points and one of polygons: what is left are polygons in pools.
class VolumeToMeshPools : public OpenvdbContestant {
 public:
  using OpenvdbContestant::OpenvdbContestant;
  [[nodiscard]] std::string name() const override { return "VolumeToMesh-pools"; }

  Outcome run() override {
    openvdb::tools::VolumeToMesh mesher(input_.iso);
    const Stopwatch watch;
    mesher(**input_.grid);
    const double seconds = watch.elapsed().wall_seconds;
    std::uint64_t triangles = 0;
    std::uint64_t quads = 0;
    for (std::size_t pool = 0; pool < mesher.polygonPoolListSize(); ++pool) {
      triangles += mesher.polygonPoolList()[pool].numTriangles();
      quads += mesher.polygonPoolList()[pool].numQuads();
    }
    return outcome_of(input_, seconds, mesher.pointListSize(), triangles, quads);
  }
};

}  // namespace

BenchmarkInput make_level_set(int size) {
  return as_input("level-set", size, sphere(size), field::FieldKind::level_set, 0);
}

BenchmarkInput make_fog(int size) {
  const openvdb::FloatGrid::Ptr grid = sphere(size);
  openvdb::tools::sdfToFogVolume(*grid);
  return as_input("fog", size, grid, field::FieldKind::density, 0.5);
}

Contestants openvdb_contestants(const BenchmarkInput& input) {
  Contestants contestants;
  if (input.grid) {
    contestants.push_back(std::make_unique<VolumeToMeshFunction>(input));
    contestants.push_back(std::make_unique<VolumeToMeshPools>(input));
  }
  return contestants;
}

}  // namespace isoextract::bench

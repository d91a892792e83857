// From a volume's file to a mesh's, with all that runs in parallel on the way: the same on one thread and on five. The
// part of the tests that scripts/test runs under the thread sanitizer.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "field/coarsen.hpp"
#include "field/resample.hpp"
#include "field/statistics.hpp"
#include "meshes/mesh_writer.hpp"
#include "support/meshes.hpp"
#include "support/temp_folder.hpp"
#include "volumes/volume_reader.hpp"

namespace isoextract {
namespace {

struct Way {
  std::filesystem::path volume;
  volumes::ReadOptions read;
  double iso = 0;
};

// All that was found and written on the way, by name: numbers in full, files byte for byte.
using Found = std::vector<std::pair<std::string, std::string>>;

template <class T>
T must(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

std::string told(const field::FieldStatistics& s) {
  return fmt::format("{} {} {} {} {} {} {}", s.samples, s.nan, s.infinite, s.min, s.max, s.mean,
                     fmt::join(s.histogram, " "));
}

std::string told(const mesh::Mesh& mesh) {
  const mesh::Topology topology = mesh::measure_topology(mesh);
  const mesh::MeshSize size = mesh::measure_size(mesh);
  const mesh::Bounds bounds = mesh::measure_bounds(mesh);
  return fmt::format("{} {} {} {} {} {} {} {}", topology.edges, topology.open_edges, topology.components,
                     topology.euler, size.area, size.volume, bounds.min.x, bounds.max.z);
}

void add_surface(const field::ScalarField& field, double iso, const std::string& name, Found& found) {
  extract::ExtractOptions options;
  options.iso = iso;
  options.cap = true;
  options.smooth_normals = true;
  options.output_from_index = field.index_to_world;
  for (const auto method : {extract::Method::mc, extract::Method::mt}) {
    options.method = method;
    const std::string label = name + (method == extract::Method::mc ? ", mc" : ", mt");
    const mesh::Mesh mesh = test::extract(field, options).mesh;
    EXPECT_GT(mesh.triangles.size(), 1000U) << label;
    found.emplace_back(label, told(mesh));
    const test::TempFolder folder;
    for (const auto format : {meshes::MeshFormat::glb, meshes::MeshFormat::ply, meshes::MeshFormat::obj}) {
      meshes::MeshWriteOptions write;
      write.format = format;
      write.ascii = format == meshes::MeshFormat::ply;
      const auto path = folder / "mesh";
      must(meshes::write_meshes({&mesh, 1}, path, write));
      found.emplace_back(fmt::format("{} as {}", label, meshes::mesh_format_info(format).name), test::read_bytes(path));
    }
  }
}

Found go(const Way& way, std::size_t threads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  Found found;
  const field::ScalarField field = must(volumes::read_volume(way.volume.string(), way.read));
  const field::FieldStatistics statistics = field::measure_statistics(field);
  found.emplace_back("statistics", told(statistics));
  found.emplace_back("suggestion", fmt::format("{}", field::suggest_iso(field, statistics).iso));
  found.emplace_back("estimate", fmt::format("{}", field::estimate_vertices(field, way.iso)));
  add_surface(field, way.iso, "as it is", found);
  add_surface(must(field::coarsen(field, 2, default_limits())), way.iso, "coarser", found);
  add_surface(must(field::resample(field, {50, 41, 62}, default_limits())), way.iso, "resampled", found);
  return found;
}

void expect_same_on_any_threads(const Way& way) {
  const Found one = go(way, 1);
  const Found five = go(way, 5);
  ASSERT_EQ(one.size(), five.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_TRUE(one[i] == five[i]) << one[i].first << " differs between one thread and five";
  }
}

std::filesystem::path sample(const char* name) {
  return std::filesystem::path(ISOEXTRACT_SOURCE_DIR) / "samples" / name;
}

TEST(WholeWay, OfSparseSamples) { expect_same_on_any_threads({sample("metaballs.vdb"), {}, 0.5}); }

TEST(WholeWay, OfPackedSamples) { expect_same_on_any_threads({sample("gyroid.nrrd"), {}, 128}); }

// Large enough to be read in several pieces, each of which is turned into the machine's byte order.
TEST(WholeWay, OfSamplesInAnotherByteOrder) {
  constexpr glm::ivec3 kDims(160, 160, 100);
  std::string bytes;
  for (int k = 0; k < kDims.z; ++k) {
    for (int j = 0; j < kDims.y; ++j) {
      for (int i = 0; i < kDims.x; ++i) {
        const auto value = static_cast<unsigned>(30000 + 9000 * (std::sin(i / 9.0) + std::cos(j / 8.0) + k / 90.0));
        bytes.push_back(static_cast<char>(value >> 8));
        bytes.push_back(static_cast<char>(value & 0xFF));
      }
    }
  }
  const test::TempFolder folder;
  test::write_bytes(folder / "v.raw", bytes);
  Way way{folder / "v.raw", {}, 34000};
  way.read.raw = volumes::RawLayout{kDims, field::SampleType::u16, std::endian::big, 0};
  expect_same_on_any_threads(way);
}

}  // namespace
}  // namespace isoextract

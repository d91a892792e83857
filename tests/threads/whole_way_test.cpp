// Converts volume files to mesh files with all parallel steps, on one thread and on three: the results are equal.
// scripts/test runs this under the thread sanitizer, which is slow, so volumes are small and threads few.
#include <bit>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "field/coarsen.hpp"
#include "field/resample.hpp"
#include "field/statistics.hpp"
#include "field/surface_estimate.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "support/meshes.hpp"
#include "support/temp_folder.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract {
namespace {

struct Way {
  std::filesystem::path volume;
  volume_io::ReadOptions read;
  double iso = 0;
};

// All results of the conversion, by name: numbers in full, files byte for byte.
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

mesh::Mesh add_surface(const field::ScalarField& field, const Way& way, extract::Method method, const std::string& name,
                       Found& found) {
  extract::ExtractOptions options;
  options.method = method;
  options.iso = way.iso;
  options.cap = true;
  options.smooth_normals = true;
  options.output_from_index = field.index_to_world;
  mesh::Mesh mesh = test::extract(field, options).mesh;
  EXPECT_GT(mesh.triangles.size(), 1000U) << name;
  found.emplace_back(name, told(mesh));
  return mesh;
}

void add_file(const mesh::Mesh& mesh, mesh_io::MeshFormat format, Found& found) {
  const test::TempFolder folder;
  mesh_io::MeshWriteOptions options;
  options.format = format;
  options.ascii = mesh_io::mesh_format_info(format).has_text_option;
  must(mesh_io::write_meshes({&mesh, 1}, folder / "mesh", options, Context()));
  found.emplace_back(mesh_io::mesh_format_info(format).name, test::read_bytes(folder / "mesh"));
}

Found go(const Way& way, std::size_t threads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  Found found;
  const field::ScalarField field = must(volume_io::read_volume(way.volume.string(), way.read, Context()));
  const field::FieldStatistics statistics = field::measure_statistics(field);
  found.emplace_back("statistics", told(statistics));
  found.emplace_back("suggestion", fmt::format("{}", field::suggest_iso(field, statistics).iso));
  found.emplace_back("estimate", fmt::format("{}", field::estimate_surface(field, way.iso).vertices));
  const auto resampled = must(
      field::resample(field, {40, 31, 52}, field::ResampleKernel::linear, field::NanHandling::left_out, Context()));
  const auto coarser = must(field::coarsen(field, 2, Context()));
  add_surface(resampled, way, extract::Method::mt, "resampled", found);
  add_surface(coarser, way, extract::Method::mt, "coarser", found);
  const mesh::Mesh mesh = add_surface(field, way, extract::Method::mc, "as it is", found);
  add_file(mesh, mesh_io::MeshFormat::glb, found);
  add_file(mesh, mesh_io::MeshFormat::ply, found);
  return found;
}

void expect_same_on_any_threads(const Way& way) {
  const Found one = go(way, 1);
  const Found three = go(way, 3);
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_TRUE(one[i] == three[i]) << one[i].first << " differs between one thread and three";
  }
}

std::filesystem::path sample(const char* name) {
  return std::filesystem::path(ISOEXTRACT_SOURCE_DIR) / "samples" / name;
}

TEST(WholeWay, ConvertsSparseSamplesAlike) { expect_same_on_any_threads({sample("metaballs.vdb"), {}, 0.5}); }

TEST(WholeWay, ConvertsPackedSamplesAlike) { expect_same_on_any_threads({sample("gyroid.nrrd"), {}, 128}); }

// Large enough for the reader to convert it to the byte order of the machine in several pieces.
TEST(WholeWay, ConvertsSwappedSamplesAlike) {
  constexpr glm::ivec3 kDims(85, 90, 75);
  std::string bytes;
  for (int k = 0; k < kDims.z; ++k) {
    for (int j = 0; j < kDims.y; ++j) {
      for (int i = 0; i < kDims.x; ++i) {
        const double value = std::sin(i / 9.0) + std::cos(j / 8.0) + k / 90.0;
        for (int shift = 56; shift >= 0; shift -= 8) {
          bytes.push_back(static_cast<char>(std::bit_cast<std::uint64_t>(value) >> shift & 0xFF));
        }
      }
    }
  }
  ASSERT_GT(bytes.size(), std::size_t{4} << 20);
  const test::TempFolder folder;
  test::write_bytes(folder / "v.raw", bytes);
  Way way{folder / "v.raw", {}, 0.5};
  way.read.raw = volume_io::RawLayout{kDims, field::SampleType::f64, std::endian::big, 0};
  expect_same_on_any_threads(way);
}

}  // namespace
}  // namespace isoextract

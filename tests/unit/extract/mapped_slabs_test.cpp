// An extraction from a large mapped file gives the pages of a slab back before the slab ends.
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include "extract/dense_input.hpp"
#include "files/mapped_file.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"
#include "support/resident_pages.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::extract {
namespace {

constexpr glm::ivec3 kVolumeDims{512, 500, 66};
constexpr std::size_t kVolumeBytes = std::size_t{512} * 500 * 66 * sizeof(float);

// Returns a field in a mapped file whose surface crosses most rows of bricks of all slabs.
field::ScalarField mapped_planes(const std::string& path) {
  field::ScalarField field = test::dense_field<float>(kVolumeDims, [](int i, int j, int k) {
    const bool is_in_gap = (j >= 116 && j < 132) || j >= 470;
    return is_in_gap ? -1 : i - 200 - 0.1 * j - 0.2 * k;
  });
  auto& samples = std::get<field::DenseSamples>(field.samples);
  test::write_bytes(path, {static_cast<const char*>(samples.data), kVolumeBytes});
  const auto file = files::InputFile::open(path, Context());
  auto mapped = files::MappedFile::map(file.value(), 0, kVolumeBytes);
  const auto owner = std::make_shared<const files::MappedFile>(std::move(mapped.value()));
  samples.owner = owner;
  samples.data = owner->data();
  samples.file_backed = true;
  return field;
}

// Notes the largest number of bytes of a mapping that are in memory when a part of the mesh is ready.
class ResidentSink final : public mesh::MeshSink {
 public:
  explicit ResidentSink(const void* mapping, bool takes_early = false) : mapping_(mapping), takes_early_(takes_early) {}

  Result<bool> begin_early(const mesh::MeshShape& /*estimate*/) override { return takes_early_; }
  Result<bool> begin(const mesh::MeshShape& /*shape*/) override {
    early_vertices = vertices;
    bytes_after_counting = resident_bytes();
    return true;
  }
  Result<void> take(const mesh::MeshPart& part) override {
    most_bytes = std::max(most_bytes, resident_bytes());
    vertices += part.positions.size();
    return {};
  }

  std::size_t most_bytes = 0;
  std::size_t bytes_after_counting = 0;
  std::size_t vertices = 0;
  std::size_t early_vertices = 0;
  bool is_known = true;

 private:
  std::size_t resident_bytes() {
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    const std::vector<bool> pages = test::resident_pages(mapping_, kVolumeBytes / page);
    is_known = is_known && !pages.empty();
    return page * static_cast<std::size_t>(std::ranges::count(pages, true));
  }

  const void* mapping_;
  bool takes_early_;
};

TEST(MappedSlabs, HoldFewRowsOfSamples) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const test::TempFolder folder;
  const field::ScalarField field = mapped_planes((folder / "samples").string());
  const auto& samples = std::get<field::DenseSamples>(field.samples);
  ASSERT_TRUE(samples.releases_pages());
  ResidentSink sink(samples.data);
  ExtractOptions options = test::options_of(Method::mc, 0);
  options.smooth_normals = true;
  options.sink = &sink;
  const auto made = make_cpu_extractor()->extract(field, options, Context());
  ASSERT_TRUE(made) << made.error().message;
  ASSERT_TRUE(made->taken);
  EXPECT_GE(sink.vertices, std::size_t{450} * 66);
  if (!sink.is_known) GTEST_SKIP() << "the system does not tell which pages are in memory";
  // A slab reads 8 slices of 1 MiB that it gives back, and up to 4 around them. Pages between runs of rows may come
  // back.
  EXPECT_LT(sink.most_bytes, std::size_t{6} << 20U);
  EXPECT_LT(sink.bytes_after_counting, std::size_t{2} << 20U);
}

// The vertices of a slice of 1 MiB read three around it. The system maps pages around these.
TEST(MappedSlabs, HoldFewSlicesWithEarlyVertices) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const test::TempFolder folder;
  const field::ScalarField field = mapped_planes((folder / "samples").string());
  ResidentSink sink(std::get<field::DenseSamples>(field.samples).data, true);
  ExtractOptions options = test::options_of(Method::mc, 0);
  options.smooth_normals = true;
  options.sink = &sink;
  const auto made = make_cpu_extractor()->extract(field, options, Context());
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(made->stats.early_vertices, sink.early_vertices);
  EXPECT_GT(sink.early_vertices, sink.vertices / 4);
  EXPECT_EQ(sink.vertices, made->taken->vertices);
  if (!sink.is_known) GTEST_SKIP() << "the system does not tell which pages are in memory";
  EXPECT_LT(sink.most_bytes, std::size_t{8} << 20U);
  EXPECT_LT(sink.bytes_after_counting, std::size_t{2} << 20U);
}

}  // namespace
}  // namespace isoextract::extract

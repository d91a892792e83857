// Sparse samples on the GPU give the CPU mesh for every size of the atlas, and only needed leaves are uploaded.
#include <limits>
#include <map>

#include "captured_surface.hpp"
#include "drawings.hpp"
#include "support/fields.hpp"
#include "support/hints.hpp"

namespace isoextract::gpu {
namespace {

using test::expect_parity;

constexpr std::uint64_t kLeaf = 512 * sizeof(float);
// Noise in blocks; some blocks are constant: background, inside, or slightly inside.
template <class T>
field::ScalarField noise_with_tiles(const glm::ivec3& dims, unsigned seed, double background) {
  std::mt19937 engine(seed);
  std::map<std::tuple<int, int, int>, int> kinds;
  const field::ScalarField dense = test::dense_field<T>(dims, [&](int i, int j, int k) -> double {
    const double random = std::uniform_int_distribution<int>(0, 100)(engine);
    const auto [kind, fresh] = kinds.try_emplace(std::tuple(i / 8, j / 8, k / 8));
    if (fresh) kind->second = std::uniform_int_distribution<int>(0, 5)(engine);
    return kind->second == 0 ? background : kind->second == 1 ? 90 : kind->second == 2 ? 51 : random;
  });
  return test::sparse_copy<T>(dense, background);
}

void move_by(field::ScalarField& field, const glm::ivec3& offset) {
  auto& samples = std::get<field::SparseSamples>(field.samples);
  for (field::SparseBlock& block : samples.blocks) block.origin += offset;
  for (field::SparseTile& tile : samples.tiles) tile.origin += offset;
}

TEST(SparseParity, MatchesForTilesAndBackground) {
  for (const double background : {0.0, 70.0}) {
    field::ScalarField field = noise_with_tiles<float>({32, 16, 24}, 3, background);
    for (const bool negative : {false, true}) {
      SCOPED_TRACE(testing::Message() << "background " << background << ", negative " << negative);
      if (negative) move_by(field, {-16, -8, -48});
      field.kind = negative ? field::FieldKind::level_set : field::FieldKind::density;
      extract::ExtractOptions options = test::at_iso(50);
      options.smooth_normals = true;
      EXPECT_GT(expect_parity(field, options), 0U);
    }
  }
}

TEST(SparseParity, MatchesForRegionsThatCutLeaves) {
  for (const double background : {0.0, 70.0}) {
    field::ScalarField field = noise_with_tiles<std::int16_t>({24, 32, 24}, 5, background);
    move_by(field, {-8, 0, 8});
    for (const field::IndexBox& region :
         {field::IndexBox{{-3, 5, 11}, {9, 20, 22}}, field::IndexBox{{-8, 0, 8}, {15, 31, 31}},
          field::IndexBox{{1, 9, 17}, {2, 10, 18}}, field::IndexBox{{-20, -20, 12}, {40, 9, 60}}}) {
      for (const bool cap : {false, true}) {
        SCOPED_TRACE(testing::Message() << "background " << background << ", region from " << region.min.x << ", cap "
                                        << cap);
        extract::ExtractOptions options = test::at_iso(50);
        options.region = region;
        options.cap = cap;
        EXPECT_GT(expect_parity(field, options), 0U);
      }
    }
    extract::ExtractOptions options = test::at_iso(50);
    options.region = field::IndexBox{{-1000, -1000, -1000}, {-990, -990, -990}};
    expect_parity(field, options);
  }
}

TEST(SparseParity, MatchesForNanInLeaves) {
  std::mt19937 engine(9);
  const field::ScalarField dense = test::dense_field<float>({24, 16, 16}, [&](int, int, int) {
    const double random = std::uniform_real_distribution<double>(-1, 1)(engine);
    return std::uniform_int_distribution<int>(0, 60)(engine) == 0 ? std::numeric_limits<double>::quiet_NaN() : random;
  });
  const field::ScalarField field = test::sparse_copy<float>(dense, -1);
  for (const extract::NanPolicy policy :
       {extract::NanPolicy::error, extract::NanPolicy::outside, extract::NanPolicy::hole}) {
    for (const bool cut : {false, true}) {
      extract::ExtractOptions options = test::at_iso(0);
      options.nan = policy;
      options.cap = cut;
      if (cut) options.region = field::IndexBox{{2, 3, 4}, {20, 12, 13}};
      options.smooth_normals = cut;
      expect_parity(field, options);
    }
  }
}

// Constants are uploaded as bits of the sample type.
template <class T>
void expect_tiles_of() {
  SCOPED_TRACE(field::sample_type_name(field::sample_type_of<T>()));
  field::ScalarField field = noise_with_tiles<T>({16, 24, 16}, 8, std::is_signed_v<T> ? -7.0 : 3.0);
  field.scale = {0.5, -4};
  EXPECT_GT(expect_parity(field, test::at_iso(21)), 0U);
}
TEST(SparseParity, MatchesForTilesOfEveryType) {
  expect_tiles_of<std::uint8_t>();
  expect_tiles_of<std::int8_t>();
  expect_tiles_of<std::uint16_t>();
  expect_tiles_of<std::uint32_t>();
  expect_tiles_of<std::int32_t>();
  expect_tiles_of<field::Half>();
  expect_tiles_of<double>();
}

TEST(SparseParity, MatchesForTilesAlone) {
  field::ScalarField field = test::sparse_copy<float>(test::random_field<float>({8, 8, 8}, 1, 2), 0);
  auto& samples = std::get<field::SparseSamples>(field.samples);
  samples.blocks.clear();
  samples.tiles = {{glm::ivec3(-16), 16, 3.0}, {glm::ivec3(0), 8, -2.0}, {glm::ivec3(8, 0, 0), 8, 1.0}};
  EXPECT_GT(expect_parity(field, test::at_iso(0.5)), 0U);
  samples.tiles.clear();
  EXPECT_EQ(expect_parity(field, test::at_iso(0.5)), 0U);
}

class Atlas : public testing::TestWithParam<extract::Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, Atlas, testing::Values(extract::Method::mc, extract::Method::mt), test::method_name);

TEST_P(Atlas, SizeDoesNotChangeMesh) {
  const field::ScalarField field = noise_with_tiles<float>({40, 40, 32}, 2, 0);
  extract::ExtractOptions options = test::at_iso(50);
  options.method = GetParam();
  options.smooth_normals = GetParam() == extract::Method::mc;
  test::SparseSurface surface(field, options);
  const std::size_t leaves = std::get<field::SparseSamples>(field.samples).blocks.size();
  const std::size_t needed = surface.needed_leaves();
  ASSERT_GT(needed, 40U);
  std::optional<mesh::Mesh> expected;
  struct Size {
    std::uint64_t slots;
    int max_texture;
    bool holds_all;
  };
  // Up to 27 leaves are needed at a time; textures of 40 samples are 5 leaves wide.
  for (const Size& size :
       {Size{1000, 2048, true}, Size{leaves, 2048, true}, Size{leaves, 40, true}, Size{27, 2048, false},
        Size{1000, 24, false}, Size{32, 32, false}, Size{leaves - 10, 64, false}}) {
    SCOPED_TRACE(testing::Message() << size.slots << " slots, textures of " << size.max_texture);
    auto source = surface.source(size.slots * kLeaf + kLeaf / 2, size.max_texture);
    ASSERT_TRUE(source) << source.error().message;
    mesh::Mesh mesh = test::captured_mesh(surface.sites(), *source, test::kFeedback);
    if (expected) test::expect_same_bytes(*expected, mesh);
    if (!expected) expected = std::move(mesh);
    const UploadFigures figures = source->uploads();
    EXPECT_EQ(figures.bytes, 4 * figures.samples);
    if (size.holds_all) {
      EXPECT_EQ(figures.samples, 512 * needed) << "each once";
      EXPECT_EQ(figures.left_out, 512 * (leaves - needed));
    } else {
      EXPECT_GE(figures.samples, 512 * needed);
    }
  }
  EXPECT_FALSE(expected->triangles.empty());
  options.edge_keys = true;
  test::expect_same_surface(test::extract(field, options).mesh, *expected);
}

TEST_P(Atlas, UploadsOnlyCrossedLeaves) {
  // All blocks are stored, because all samples differ.
  const field::ScalarField dense = test::dense_field<float>({64, 64, 64}, [](int i, int j, int k) {
    return 9.3 - glm::length(glm::dvec3(i, j, k) - glm::dvec3(30.1, 31.2, 30.3));
  });
  const field::ScalarField field = test::sparse_copy<float>(dense, -99);
  extract::ExtractOptions options = test::at_iso(0);
  options.method = GetParam();
  test::SparseSurface surface(field, options);
  auto source = surface.source(kLeaf * 1000, 2048);
  ASSERT_TRUE(source);
  const mesh::Mesh mesh = test::captured_mesh(surface.sites(), *source, test::kFeedback);
  test::expect_sound(mesh, true);
  const UploadFigures figures = source->uploads();
  EXPECT_EQ(figures.samples, 512 * surface.needed_leaves());
  EXPECT_LT(figures.samples, 512U * 100);
  EXPECT_EQ(figures.left_out, 512 * 512 - figures.samples);
}

TEST_P(Atlas, FailsIfTooSmall) {
  const field::ScalarField field = noise_with_tiles<float>({40, 40, 40}, 2, 0);
  extract::ExtractOptions options = test::at_iso(50);
  options.method = GetParam();
  const test::SparseSurface surface(field, options);
  for (const auto& [bytes, max_texture] : {std::pair(27 * kLeaf - 1, 2048), {1000 * kLeaf, 16}, {27 * kLeaf, 23}}) {
    const auto source = surface.source(bytes, max_texture);
    ASSERT_FALSE(source);
    EXPECT_EQ(source.error().code, ErrorCode::usage);
    EXPECT_TRUE(test::has_step(source.error().hint, Remedy::raise, Setting::gpu_memory));
  }
}

}  // namespace
}  // namespace isoextract::gpu

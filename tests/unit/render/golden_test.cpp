// Compares small pictures of known scenes with stored ones, so that a person looks at every change. If one differs, the
// new picture and the difference stay in the build folder. With ISOEXTRACT_KEEP_PICTURES set, new pictures replace the
// stored ones.
#include <cstdlib>
#include <filesystem>
#include <string>

#include <png.h>

#include "image_io/png_writer.hpp"
#include "render/surface_normals.hpp"
#include "unit/render/drawing.hpp"

namespace isoextract::render {
namespace {

namespace fs = std::filesystem;

constexpr int kTolerance = 2;  // of 255, for rounding differences between processors

struct Bytes {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;
};

Bytes read_png(const fs::path& path) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&header, path.c_str()) == 0) return {};
  header.format = PNG_FORMAT_RGBA;
  Bytes image{static_cast<int>(header.width), static_cast<int>(header.height), {}};
  image.rgba.resize(PNG_IMAGE_SIZE(header));
  if (png_image_finish_read(&header, nullptr, image.rgba.data(), 0, nullptr) == 0) return {};
  return image;
}

void keep(const Picture& picture, const fs::path& path) {
  fs::create_directories(path.parent_path());
  auto file = files::OutputFile::create(path);
  ASSERT_TRUE(file);
  ASSERT_TRUE(image_io::write_png(*file, {picture.width, picture.height, picture.color.span(), {}, {}}, Context()));
  ASSERT_TRUE(file->commit());
}

void expect_as_kept(const Picture& picture, const std::string& name) {
  const fs::path kept = fs::path(ISOEXTRACT_SOURCE_DIR) / "tests/unit/render/pictures" / (name + ".png");
  const fs::path folder = fs::path(ISOEXTRACT_BINARY_DIR) / "pictures";
  if (std::getenv("ISOEXTRACT_KEEP_PICTURES") != nullptr) keep(picture, kept);
  const fs::path drawn = folder / (name + ".png");
  keep(picture, drawn);
  const Bytes expected = read_png(kept);
  const Bytes found = read_png(drawn);
  ASSERT_FALSE(expected.rgba.empty()) << kept;
  ASSERT_EQ(std::pair(found.width, found.height), std::pair(expected.width, expected.height));
  int largest = 0;
  Bytes difference = found;
  for (std::size_t i = 0; i < found.rgba.size(); ++i) {
    const int off = std::abs(int{found.rgba[i]} - int{expected.rgba[i]});
    largest = std::max(largest, off);
    difference.rgba[i] = i % 4 == 3 ? 255 : static_cast<std::uint8_t>(std::min(255, 16 * off));
  }
  EXPECT_LE(largest, kTolerance) << drawn;
  if (largest <= kTolerance) return;
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(found.width);
  header.height = static_cast<png_uint_32>(found.height);
  header.format = PNG_FORMAT_RGBA;
  const fs::path shown = folder / (name + "_difference.png");
  png_image_write_to_file(&header, shown.c_str(), 0, difference.rgba.data(), 0, nullptr);
}

constexpr PictureSize kSmall{64, 48};

TEST(Golden, MatchesVolumeWithSurfaces) {
  const field::ScalarField field = test::ball(32);
  const mesh::Mesh rectangle = test::rectangle(15, 8, 40, -4, 24);
  mesh::Mesh sphere = test::sphere(16, false, "sphere", {15, 15, 15});
  for (glm::vec3& p : sphere.positions) p *= 6.0F;
  ASSERT_TRUE(add_normals(sphere, "sphere", Context()));
  Volume volume{&field, field.index_to_world,
                TransferFunction::create(built_in_points(BuiltInTransfer::fire, 0, 1)).value(), 1};
  Scene scene;
  scene.volume = &volume;
  scene.surfaces = {{&rectangle, {0.1, 0.4, 0.9}, 0.5}, {&sphere, {0.8, 0.8, 0.8}, 1}};
  scene.background = {0.02, 0.02, 0.03, 1};
  const Camera camera = frame_box({{0, 0, 0}, {31, 31, 31}}, {35, 20}, UpAxis::z, kSmall);
  expect_as_kept(test::draw(scene, camera, {kSmall}).picture, "volume_with_surfaces");
}

TEST(Golden, MatchesFlatTransparentSurfaces) {
  const mesh::Mesh inner = test::sphere(6, false);
  mesh::Mesh outer = test::sphere(9, false);
  for (glm::vec3& p : outer.positions) p *= 1.6F;
  Scene scene;
  scene.surfaces = {{&outer, {0.2, 0.7, 0.4}, 0.35, Shading::flat}, {&inner, {0.9, 0.5, 0.2}, 1, Shading::flat}};
  const Camera camera = frame_box({glm::dvec3(-1.6), glm::dvec3(1.6)}, {10, 30}, UpAxis::z, kSmall);
  expect_as_kept(test::draw(scene, camera, {kSmall}).picture, "flat_and_see_through");
}

}  // namespace
}  // namespace isoextract::render

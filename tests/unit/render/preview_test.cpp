// Previews, scale bars, text in pictures, contact sheets.
#include "render/preview.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <vector>

#include <gtest/gtest.h>

#include "render/contact_sheet.hpp"
#include "render/picture_text.hpp"
#include "support/box_mesh.hpp"

namespace isoextract::render {
namespace {

Picture preview_of(const mesh::Mesh& mesh, const PreviewOptions& options) {
  Surface surface;
  surface.mesh = &mesh;
  surface.shading = Shading::flat;
  const auto renderer = make_cpu_renderer();
  auto drawn = draw_preview(std::span(&surface, 1), options, *renderer, Context());
  EXPECT_TRUE(drawn.has_value()) << drawn.error().message;
  return std::move(drawn->picture);
}

TEST(Preview, FitsMeshIntoPicture) {
  for (const glm::vec3 half :
       {glm::vec3(1, 1, 1), glm::vec3(20, 1, 1), glm::vec3(1, 1, 30), glm::vec3(1e-6F, 2e-6F, 1e-6F)}) {
    const mesh::Mesh mesh = test::box_mesh(-half, half);
    PreviewOptions options;
    options.size = {120, 90};
    options.scale_bar = false;
    const Picture picture = preview_of(mesh, options);
    ASSERT_EQ(picture.width, 120);
    ASSERT_EQ(picture.height, 90);
    glm::ivec2 low{120, 90};
    glm::ivec2 high{-1};
    for (int y = 0; y < 90; ++y) {
      for (int x = 0; x < 120; ++x) {
        if (!std::isfinite(picture.depth[static_cast<std::size_t>(x + 120 * y)])) continue;
        low = glm::min(low, glm::ivec2(x, y));
        high = glm::max(high, glm::ivec2(x, y));
      }
    }
    EXPECT_GT(std::min({low.x, low.y, 119 - high.x, 89 - high.y}), 1);
    EXPECT_GT(std::max((high.x - low.x) / 120.0, (high.y - low.y) / 90.0), 0.65);
  }
}

TEST(Preview, DrawsBackgroundWithoutSurface) {
  PreviewOptions options;
  options.size = {8, 6};
  const Picture picture = preview_of(mesh::Mesh(), options);
  for (const glm::vec4& pixel : picture.color) EXPECT_EQ(pixel, picture.color[0]);
  EXPECT_EQ(picture.color[0].a, 1.0F);
}

// Adds a box of its own color, offset from the center by `right`, `up` and `near` as the camera sees it.
class BoxesInView {
 public:
  explicit BoxesInView(const ViewAngles& angles) {
    options_.size = {160, 120};
    options_.angles = angles;
    options_.box = field::Box{glm::dvec3(-4), glm::dvec3(4)};
    options_.scale_bar = false;
    camera_ = frame_box(*options_.box, angles, options_.up, options_.size);
  }
  void add(double right, double up, double near, double half, const glm::dvec3& color) {
    const glm::vec3 at(glm::transpose(camera_.rotation()) * glm::dvec3(right, up, near));
    const auto side = static_cast<float>(half);
    const mesh::Mesh& mesh = meshes_.emplace_back(test::box_mesh(at - side, at + side));
    surfaces_.push_back({&mesh, color, 1, Shading::flat});
  }
  [[nodiscard]] PreviewOptions& options() { return options_; }
  [[nodiscard]] Picture draw() const {
    const auto renderer = make_cpu_renderer();
    auto drawn = draw_preview(surfaces_, options_, *renderer, Context());
    EXPECT_TRUE(drawn.has_value()) << drawn.error().message;
    return std::move(drawn->picture);
  }

 private:
  PreviewOptions options_;
  Camera camera_;
  std::deque<mesh::Mesh> meshes_;
  std::vector<Surface> surfaces_;
};

TEST(Preview, OrientsPictureAndHidesFartherBoxes) {
  for (const ViewAngles& angles : {ViewAngles{0, 0}, ViewAngles{35, 20}, ViewAngles{-110, -40}}) {
    BoxesInView boxes(angles);
    boxes.add(0, 0, 0, 0.5, {1, 0, 0});
    boxes.add(2, 1, 0, 0.5, {0, 1, 0});
    boxes.add(0, 0, 2, 0.3, {0, 0, 1});  // in front of the red one
    const Picture picture = boxes.draw();
    std::array<glm::dvec2, 3> middle{};
    std::array<int, 3> count{};
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        const glm::vec4& pixel = picture.color[static_cast<std::size_t>(x + picture.width * y)];
        for (int c = 0; c < 3; ++c) {
          if (pixel[c] <= 2 * std::max(pixel[(c + 1) % 3], pixel[(c + 2) % 3])) continue;
          middle[static_cast<std::size_t>(c)] += glm::dvec2(x, y);
          ++count[static_cast<std::size_t>(c)];
        }
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_GT(count[c], 20) << c;
      middle[c] /= count[c];
    }
    EXPECT_GT(middle[1].x, middle[0].x + 10) << angles.azimuth;
    EXPECT_LT(middle[1].y, middle[0].y - 5) << angles.azimuth;
    EXPECT_NEAR(middle[2].x, 79.5, 1) << angles.azimuth;
    EXPECT_NEAR(middle[2].y, 59.5, 1) << angles.azimuth;
    const auto depth = [&](const glm::ivec2& at) {
      return picture.depth[static_cast<std::size_t>(at.x + picture.width * at.y)];
    };
    EXPECT_GT(picture.color[static_cast<std::size_t>(80 + picture.width * 60)].b, 0.2F);
    EXPECT_LT(depth({80, 60}), depth(glm::ivec2(middle[1])) - 1) << angles.azimuth;
  }
}

TEST(Preview, DrawsScaleBarOfStatedLength) {
  for (const PictureSize size : {PictureSize{160, 120}, PictureSize{640, 720}}) {
    BoxesInView boxes({35, 20, 17.0});
    boxes.add(0, 0, 0, 0.5, {1, 0, 0});
    boxes.options().size = size;
    const Picture without = boxes.draw();
    boxes.options().scale_bar = true;
    const Picture with = boxes.draw();
    const Camera camera = frame_box(*boxes.options().box, boxes.options().angles, UpAxis::z, size);
    const ScaleBar bar = scale_bar(camera, size, "");
    // The lowest row that differs from the background has the whole bar and nothing else.
    int first = -1;
    int count = 0;
    for (int y = size.height - 1; y >= 0 && count == 0; --y) {
      for (int x = 0; x < size.width; ++x) {
        const auto at = static_cast<std::size_t>(x + size.width * y);
        if (with.color[at] == without.color[at]) continue;
        if (first < 0) first = x;
        EXPECT_EQ(x, first + count);
        ++count;
      }
    }
    EXPECT_EQ(count, bar.pixels);
    EXPECT_GT(first, 0);
  }
}

TEST(ScaleBar, HasRoundLengthOfMatchingPixels) {
  for (const double size : {1e-9, 0.3, 1.0, 7.0, 42.0, 3e7}) {
    const PictureSize pixels{800, 600};
    const Camera camera = frame_box({glm::dvec3(-size), glm::dvec3(size)}, {}, UpAxis::z, pixels);
    const ScaleBar bar = scale_bar(camera, pixels, "mm");
    const double digits = bar.length / std::pow(10, std::floor(std::log10(bar.length * (1 + 1e-9))));
    EXPECT_TRUE(std::abs(digits - 1) < 1e-6 || std::abs(digits - 2) < 1e-6 || std::abs(digits - 5) < 1e-6) << digits;
    EXPECT_GT(bar.pixels, 800 / 4 / 2.6);
    EXPECT_LE(bar.pixels, 800 / 4 + 1);
    EXPECT_TRUE(bar.text.ends_with(" mm"));
    // Projects two points that far apart, at the target's distance, and compares their distance in pixels.
    const glm::dmat4 clip = camera.clip_from_world(pixels);
    const glm::dvec3 right = glm::transpose(camera.rotation()) * glm::dvec3(bar.length, 0, 0);
    const glm::dvec4 a = clip * glm::dvec4(camera.target, 1);
    const glm::dvec4 b = clip * glm::dvec4(camera.target + right, 1);
    EXPECT_NEAR((b.x / b.w - a.x / a.w) * 400, bar.pixels, 0.6);
  }
}

TEST(PictureText, DrawsTextClippedToPicture) {
  auto picture = make_picture(20, 12, Context());
  ASSERT_TRUE(picture.has_value());
  fill_box(*picture, {0, 0}, {20, 12}, glm::vec3(1));
  draw_text(*picture, {1, 1}, "1L", 1, glm::vec3(0));
  const auto dark = [&](int x, int y) { return picture->color[static_cast<std::size_t>(x + 20 * y)].r < 0.5F; };
  // The foot of the 1 is three dots wide, its stem one.
  EXPECT_TRUE(dark(2, 8) && dark(3, 8) && dark(4, 8) && !dark(5, 8));
  EXPECT_TRUE(dark(3, 5) && !dark(2, 5) && !dark(4, 5));
  EXPECT_EQ(text_size("1l", 2), glm::ivec2(24, 18));
  draw_text(*picture, {18, -3}, "888", 3, glm::vec3(0));  // partly outside of the picture
}

TEST(ContactSheet, PlacesPicturesInOrder) {
  auto sheet = ContactSheet::create({30, 20}, 5, Context());
  ASSERT_TRUE(sheet.has_value());
  for (std::size_t n = 0; n < 5; ++n) {
    auto cell = make_picture(30, 20, Context());
    ASSERT_TRUE(cell.has_value());
    fill_box(*cell, {0, 0}, {30, 20}, glm::vec3(0.1F * static_cast<float>(n + 1), 0, 0));
    sheet->place(n, *cell, "a long label that does not fit");
  }
  const Picture& picture = sheet->picture();
  for (std::size_t n = 0; n < 5; ++n) {
    std::size_t found = 0;
    for (const glm::vec4& pixel : picture.color) {
      found += pixel == glm::vec4(0.1F * static_cast<float>(n + 1), 0, 0, 1) ? 1 : 0;
    }
    EXPECT_EQ(found, 600U) << n;
  }
  EXPECT_FALSE(ContactSheet::create({9000, 9000}, 9, Context()).has_value());
}

// The target is between the eye and the box, so that no corner asks for a distance.
TEST(Preview, DrawsBoxFarBehindTarget) {
  const mesh::Mesh mesh = test::box_mesh(glm::vec3(-1), glm::vec3(1));
  PreviewOptions options;
  options.size = {120, 90};
  options.scale_bar = false;
  options.angles.azimuth = 0;
  options.angles.elevation = 0;
  const Camera camera = frame_box({glm::dvec3(-1), glm::dvec3(1)}, options.angles, options.up, options.size);
  options.angles.look_at = glm::transpose(camera.rotation()) * glm::dvec3(0, 0, 4);
  const Picture picture = preview_of(mesh, options);
  ASSERT_EQ(picture.width, 120);
  EXPECT_TRUE(std::isfinite(picture.depth[60 + 120 * 45]));
}

}  // namespace
}  // namespace isoextract::render

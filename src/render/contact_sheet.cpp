#include "render/contact_sheet.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "render/picture_text.hpp"

namespace isoextract::render {
namespace {

constexpr int kGap = 4;          // pixels between pictures and around them
constexpr double kAspect = 1.6;  // approximate width / height of the sheet
constexpr glm::vec3 kSheetColor{1.0F};

int dot_of(const PictureSize& cell) { return std::max(1, cell.height / 160); }

}  // namespace

Result<ContactSheet> ContactSheet::create(const PictureSize& cell, std::size_t count, const Context& context) {
  ContactSheet sheet;
  sheet.cell_ = cell;
  sheet.label_dot_ = dot_of(cell);
  const int wide = cell.width + kGap;
  const int high = cell.height + kGap + text_size("0", sheet.label_dot_).y;
  const double across = std::sqrt(static_cast<double>(count) * kAspect * high / wide);
  const double columns = std::clamp(std::round(across), 1.0, static_cast<double>(count));
  const double rows = std::ceil(static_cast<double>(count) / columns);
  if (kGap + columns * wide > PictureSize::kMaxSide || kGap + rows * high > PictureSize::kMaxSide) {
    return fail(ErrorCode::usage,
                fmt::format("the sheet of {1} pictures of {2} x {3} pixels exceeds {0} x {0} pixels",
                            PictureSize::kMaxSide, count, cell.width, cell.height),
                "use fewer or smaller pictures");
  }
  sheet.columns_ = static_cast<int>(columns);
  sheet.picture_ = TRY(make_picture(kGap + sheet.columns_ * wide, kGap + static_cast<int>(rows) * high, context));
  Picture& picture = sheet.picture_;
  std::ranges::fill(picture.depth, std::numeric_limits<float>::infinity());
  std::ranges::fill(picture.normals, glm::vec3(0.0F));
  fill_box(picture, {0, 0}, {picture.width, picture.height}, kSheetColor);
  return sheet;
}

void ContactSheet::place(std::size_t n, const Picture& picture, std::string_view label) {
  const auto columns = static_cast<std::size_t>(columns_);
  const int label_height = text_size("0", label_dot_).y;
  const glm::ivec2 corner{kGap + static_cast<int>(n % columns) * (cell_.width + kGap),
                          kGap + static_cast<int>(n / columns) * (cell_.height + kGap + label_height)};
  for (int y = 0; y < picture.height; ++y) {
    const auto* const row = picture.color.begin() + static_cast<std::ptrdiff_t>(y) * picture.width;
    std::copy_n(row, picture.width,
                picture_.color.begin() + static_cast<std::ptrdiff_t>(corner.y + y) * picture_.width + corner.x);
  }
  const auto fits = static_cast<std::size_t>(std::max(0, cell_.width / text_size("0", label_dot_).x));
  draw_text(picture_, {corner.x, corner.y + cell_.height}, label.substr(0, fits), label_dot_, kTextColor);
}

}  // namespace isoextract::render

// Many small pictures on one sheet, row by row, each with a label below it.
#pragma once

#include <cstddef>
#include <string_view>

#include "base/context.hpp"
#include "base/error.hpp"
#include "render/camera.hpp"
#include "render/picture.hpp"

namespace isoextract::render {

class ContactSheet {
 public:
  // For `count` pictures of one size, at least one. Fails with ErrorCode::usage where the sheet would be larger than a
  // picture may be, and with ErrorCode::input where memory is missing.
  [[nodiscard]] static Result<ContactSheet> create(const PictureSize& cell, std::size_t count, const Context& context);

  // The n-th from the upper left; `picture` has the size of a cell. Words that do not fit below it are cut off.
  void place(std::size_t n, const Picture& picture, std::string_view label);

  [[nodiscard]] const Picture& picture() const { return picture_; }
  [[nodiscard]] int columns() const { return columns_; }

 private:
  ContactSheet() = default;

  PictureSize cell_;
  int columns_ = 1;
  int label_dot_ = 1;
  Picture picture_;
};

}  // namespace isoextract::render

// Arranges many small pictures on one sheet, row by row, each with a label below it.
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
  // Makes a white sheet for `count` pictures of size `cell`; `count` is at least 1. Fails with ErrorCode::usage if the
  // sheet would exceed PictureSize::kMaxSide, and with ErrorCode::out_of_memory if memory is short.
  [[nodiscard]] static Result<ContactSheet> create(const PictureSize& cell, std::size_t count, const Context& context);

  // Places picture n, counted from 0 at the upper left; `picture` has the size of a cell. Truncates a label that is
  // wider than the cell.
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

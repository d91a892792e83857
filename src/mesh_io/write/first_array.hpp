// The first array of a file. Its values may come before the bytes in front of it are known.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "base/error.hpp"
#include "files/output_file.hpp"

namespace isoextract::mesh_io {

class FirstArray {
 public:
  // Values can be filled in from file offset `at` on, a guess. The file grows with them, so a wrong guess of their
  // number takes no room.
  void begin_early(std::uint64_t at) {
    is_early_ = true;
    at_ = at;
  }

  // Writes the start of the file up to the array, and makes room for all of it. Early values move behind the start.
  [[nodiscard]] Result<void> begin(files::OutputFile& file, const std::string& start, std::uint64_t bytes) {
    if (!is_early_) {
      TRY(file.write(start));
      at_ = TRY(file.extend(bytes));
      return {};
    }
    TRY(file.resize(at_ + bytes));
    TRY(file.move_end(at_, start.size()));
    at_ = start.size();
    return file.overwrite(0, std::as_bytes(std::span(start)));
  }

  // Returns the file offset of the array. begin() may change it.
  [[nodiscard]] std::uint64_t place() const { return at_; }

 private:
  bool is_early_ = false;
  std::uint64_t at_ = 0;
};

}  // namespace isoextract::mesh_io

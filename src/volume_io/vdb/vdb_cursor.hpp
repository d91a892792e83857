// Reads a VDB file from front to back, with jumps, through a window of it. Sizes in a file are not to be trusted: what
// would be read past the end is VdbDamaged.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "base/error.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::volume_io {

// Thrown while a VDB file is read, and caught where this room ends: what is wrong with the file.
class VdbDamaged : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Likewise: what may be right, but is not read here.
class VdbUnsupported : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Likewise: why the work ends although the file may be sound.
class VdbRefused : public std::runtime_error {
 public:
  explicit VdbRefused(Error why) : std::runtime_error(why.message), error(std::move(why)) {}
  Error error;
};

class VdbCursor {
 public:
  // What is read counts as progress.
  explicit VdbCursor(const files::InputFile& file) : file_(file), end_(file.size()) {}

  [[nodiscard]] std::uint64_t size() const { return file_.size(); }
  [[nodiscard]] std::uint64_t position() const { return begin_ + at_; }
  void seek(std::uint64_t position);
  // From now on, what is sought and taken must not lie behind `end`: at first the file's end. Seek next where the
  // cursor is behind it already.
  void set_end(std::uint64_t end) { end_ = end; }

  // Sees to it that the next `count` bytes are in the window, or as many as the file has. Throws VdbRefused where they
  // cannot be read, or where the work is to end.
  void prepare(std::uint64_t count);
  [[nodiscard]] bool is_prepared(std::uint64_t count) const;

  // The next bytes. They stay where they are until more than the window holds is asked for, and as long as somebody
  // keeps window().
  [[nodiscard]] std::span<const std::byte> take(std::uint64_t count);
  [[nodiscard]] std::shared_ptr<const std::byte[]> window() const { return window_; }

  template <class T>
  [[nodiscard]] T read_value() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  // A length and that many characters. Throws VdbUnsupported for names that are longer than any should be.
  [[nodiscard]] std::string read_name();
  [[nodiscard]] std::string read_text(std::uint64_t length);

 private:
  [[nodiscard]] const char* what_ends() const { return end_ < size() ? "grid" : "file"; }

  const files::InputFile& file_;
  std::uint64_t end_;
  std::shared_ptr<std::byte[]> window_;
  std::uint64_t begin_ = 0;  // of the window, in the file
  std::size_t length_ = 0;   // of the window
  std::size_t at_ = 0;       // in the window
};

}  // namespace isoextract::volume_io

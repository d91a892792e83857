// Reads a VDB file through a buffer (the window). Reads advance the position; seek() sets it. Sizes in the file are not
// trusted: reading past the end throws InvalidVdb.
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

// Thrown if a VDB file is damaged, and caught in volume_io. The text says what is wrong with the file.
class InvalidVdb : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Thrown for content that may be valid but is not supported.
class UnsupportedVdb : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Thrown for errors that are not the file's fault, such as cancellation.
class VdbReadError : public std::runtime_error {
 public:
  explicit VdbReadError(Error why) : std::runtime_error(why.message), error(std::move(why)) {}
  Error error;
};

class VdbCursor {
 public:
  // Makes a cursor at the start of the file. Its reads report their bytes as progress of the file's context.
  explicit VdbCursor(const files::InputFile& file) : file_(file), end_(file.size()) {}

  [[nodiscard]] std::uint64_t size() const { return file_.size(); }
  [[nodiscard]] std::uint64_t position() const { return begin_ + at_; }
  void seek(std::uint64_t position);
  // Limits seeking and reading to positions before `end`, at first the end of the file. If the position is already
  // beyond `end`, the next call must be seek().
  void set_end(std::uint64_t end) { end_ = end; }

  // Loads the next `count` bytes into the window, or all that remain. Throws VdbReadError if they cannot be read or the
  // work is cancelled.
  void prepare(std::uint64_t count);
  [[nodiscard]] bool is_prepared(std::uint64_t count) const;

  // Returns the next bytes. They stay valid while the caller holds their window(). Otherwise they stay valid until a
  // take(), prepare() or seek() beyond the window.
  [[nodiscard]] std::span<const std::byte> take(std::uint64_t count);
  [[nodiscard]] std::shared_ptr<const std::byte[]> window() const { return window_; }

  template <class T>
  [[nodiscard]] T read_value() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  // Reads a length and that many characters. Throws UnsupportedVdb if the name is too long.
  [[nodiscard]] std::string read_name();
  [[nodiscard]] std::string read_text(std::uint64_t length);

 private:
  [[nodiscard]] const char* range_name() const { return end_ < size() ? "grid" : "file"; }

  const files::InputFile& file_;
  std::uint64_t end_;
  std::shared_ptr<std::byte[]> window_;
  std::uint64_t begin_ = 0;  // position of the window in the file
  std::size_t length_ = 0;   // length of the window
  std::size_t at_ = 0;       // position in the window
};

}  // namespace isoextract::volume_io

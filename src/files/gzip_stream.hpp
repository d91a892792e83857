// The content of a gzip file from front to back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "base/error.hpp"
#include "files/packed_input.hpp"

namespace isoextract::files {

// Deflate cannot shrink anything below 1/1032 of its size.
inline constexpr std::uint64_t kMostInflated = 1032;

// Outlived by the file it reads. Members may follow each other; what follows the last one is not looked at.
class GzipStream {
 public:
  // `offset` is where in the file the packed data begins.
  [[nodiscard]] static Result<GzipStream> open(const InputFile& file, std::uint64_t offset);

  // How many bytes came; fewer than asked for only at the end of intact data. At most 2 GiB at a time.
  [[nodiscard]] Result<std::size_t> inflate(std::span<std::byte> out);

 private:
  explicit GzipStream(PackedInput input) : input_(std::move(input)) {}

  // Behind a member: whether another one follows.
  [[nodiscard]] Result<bool> begin_next_member();
  [[nodiscard]] tl::unexpected<Error> damaged(const char* why) const;

  PackedInput input_;
  bool ended_ = false;  // the last member has
};

}  // namespace isoextract::files

// The content of a gzip file from front to back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "base/error.hpp"
#include "files/file_bytes.hpp"

struct gzFile_s;

namespace isoextract::files {

// Deflate cannot shrink anything below 1/1032 of its size.
inline constexpr std::uint64_t kMostInflated = 1032;

// Outlived by the file it reads. What it has read of it counts when it goes.
class GzipStream {
 public:
  // `offset` is where in the file the packed data begins. One stream of a file at a time: they share its place.
  [[nodiscard]] static Result<GzipStream> open(const files::InputFile& file, std::uint64_t offset);

  // How many bytes came; fewer than asked for only at the end of intact data. At most 2 GiB at a time.
  [[nodiscard]] Result<std::size_t> inflate(std::span<std::byte> out);

 private:
  struct Close {
    const files::InputFile* file = nullptr;
    std::uint64_t start = 0;
    void operator()(gzFile_s* gzip) const;
  };
  using Handle = std::unique_ptr<gzFile_s, Close>;
  explicit GzipStream(Handle gzip) : gzip_(std::move(gzip)) {}

  Handle gzip_;
};

}  // namespace isoextract::files

#include "files/gzip_stream.hpp"

#include <string_view>

#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

namespace isoextract::files {

void GzipStream::Close::operator()(gzFile_s* gzip) const {
  const auto end = static_cast<std::int64_t>(::gzoffset(gzip));
  if (end > static_cast<std::int64_t>(start)) file->count_bytes_read(static_cast<std::uint64_t>(end) - start);
  ::gzclose_r(gzip);
}

Result<GzipStream> GzipStream::open(const files::InputFile& file, std::uint64_t offset) {
  const int descriptor = ::dup(file.descriptor());
  const auto cannot = [&] { return fail(ErrorCode::input, file.name() + ": cannot be read as gzip"); };
  if (descriptor < 0) return cannot();
  gzFile gzip = nullptr;
  if (::lseek(descriptor, static_cast<off_t>(offset), SEEK_SET) >= 0) gzip = ::gzdopen(descriptor, "rb");
  if (gzip == nullptr) {
    ::close(descriptor);
    return cannot();
  }
  ::gzbuffer(gzip, 1 << 18);
  return GzipStream(Handle(gzip, Close{&file, offset}));
}

Result<std::size_t> GzipStream::inflate(std::span<std::byte> out) {
  const files::InputFile& file = *gzip_.get_deleter().file;
  const int got = ::gzread(gzip_.get(), out.data(), static_cast<unsigned>(out.size()));
  int code = Z_OK;
  // zlib starts its text with its own name of the file: "<fd:5>: ".
  std::string_view text = ::gzerror(gzip_.get(), &code);
  if (const std::size_t colon = text.find(": "); colon != std::string_view::npos) text.remove_prefix(colon + 2);
  if (::gzdirect(gzip_.get()) != 0)
    return fail(ErrorCode::input, file.name() + ": expected gzip data, found other bytes");
  if (got < 0 || (code != Z_OK && code != Z_STREAM_END)) {
    return fail(ErrorCode::input, fmt::format("{}: the gzip data is damaged or cut off: {}", file.name(), text));
  }
  return static_cast<std::size_t>(got);
}

}  // namespace isoextract::files

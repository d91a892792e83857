#include "files/compressed_input.hpp"

#include <algorithm>
#include <cstddef>
#include <new>
#include <span>

#include <zlib.h>

namespace isoextract::files {

void CompressedInput::End::operator()(z_stream_s* stream) const {
  ::inflateEnd(stream);
  delete stream;
}

CompressedInput::CompressedInput(const InputFile& file, std::uint64_t begin, std::uint64_t end, int window_bits)
    : file_(&file), next_(begin), end_(end) {
  auto stream = std::make_unique<z_stream_s>();
  if (::inflateInit2(stream.get(), window_bits) != Z_OK) throw std::bad_alloc();
  stream_.reset(stream.release());
}

CompressedInput CompressedInput::copy_for(const InputFile& file) const {
  CompressedInput copy;
  copy.file_ = &file;
  copy.next_ = next_;
  copy.end_ = end_;
  auto stream = std::make_unique<z_stream_s>();
  if (::inflateCopy(stream.get(), stream_.get()) != Z_OK) throw std::bad_alloc();
  copy.stream_.reset(stream.release());
  copy.packed_.assign(packed_.end() - static_cast<std::ptrdiff_t>(stream_->avail_in), packed_.end());
  copy.stream_->next_in = reinterpret_cast<Bytef*>(copy.packed_.data());
  return copy;
}

Result<void> CompressedInput::refill() {
  constexpr std::uint64_t kBlock = std::uint64_t{1} << 18;
  const std::size_t left = stream_->avail_in;
  std::copy(packed_.end() - static_cast<std::ptrdiff_t>(left), packed_.end(), packed_.begin());
  const std::uint64_t more = is_read() ? 0 : std::min(kBlock, end_ - next_);
  packed_.resize(left + static_cast<std::size_t>(more));
  TRY(file_->read_at(next_, std::span(packed_).subspan(left)));
  next_ += more;
  stream_->next_in = reinterpret_cast<Bytef*>(packed_.data());
  stream_->avail_in = static_cast<uInt>(packed_.size());
  return {};
}

}  // namespace isoextract::files

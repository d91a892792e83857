// Decompresses a gzip file sequentially.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "base/error.hpp"
#include "files/compressed_input.hpp"

namespace isoextract::files {

// Largest ratio of decompressed to compressed size that deflate can reach.
inline constexpr std::uint64_t kMaxDeflateRatio = 1032;

// The file must outlive the stream. Reads all consecutive gzip members; ignores data after the last one.
class GzipStream {
 public:
  // Starts at byte `offset` of the file. Fails with ErrorCode::input if there is no gzip signature.
  [[nodiscard]] static Result<GzipStream> open(const InputFile& file, std::uint64_t offset);

  // Returns the number of bytes written to `out`; it is smaller than out.size() only at the end of intact data. `out`
  // must be smaller than 4 GiB. Fails with ErrorCode::input if the data is damaged or cut off.
  [[nodiscard]] Result<std::size_t> inflate(std::span<std::byte> out);
  // Inflates as inflate() does, but accepts data that is cut off: returns the number of bytes before the cut, and 0 in
  // later calls. is_cut_off() becomes true.
  [[nodiscard]] Result<std::size_t> inflate_to_cut(std::span<std::byte> out);
  [[nodiscard]] bool is_cut_off() const { return is_cut_off_; }

  // Returns a copy that goes on from the same place; see CompressedInput::copy_for().
  [[nodiscard]] GzipStream copy_for(const InputFile& file) const;

 private:
  explicit GzipStream(CompressedInput input) : input_(std::move(input)) {}

  // Starts the next member, if there is one, and returns whether there is. Call at the end of a member.
  [[nodiscard]] Result<bool> begin_next_member();
  [[nodiscard]] tl::unexpected<Error> damaged(const char* why) const;

  CompressedInput input_;
  bool ended_ = false;  // whether the last member is fully read
  bool is_cut_off_ = false;
};

}  // namespace isoextract::files

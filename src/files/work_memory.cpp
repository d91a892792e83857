#include "files/work_memory.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "base/byte_size.hpp"
#include "base/pages.hpp"

namespace isoextract::files {

Result<WorkMemory> WorkMemory::make(std::uint64_t bytes, const FileUse& use, const Context& context,
                                    const std::string& what) {
  std::string reason;
  if (use.prefers_file && bytes >= use.least_bytes) {
    auto file = ScratchFile::make(bytes);
    if (file) return WorkMemory(std::move(*file));
    reason = std::move(file.error());
  }
  auto reserved = context.reserve(bytes, what);
  if (!reserved && !reason.empty()) return refuse(bytes, use, std::move(reserved.error()), reason);
  if (!reserved) return make_in_file(bytes, use, std::move(reserved.error()));
  return WorkMemory(
      ReservedBuffer<std::byte>{Buffer<std::byte>(static_cast<std::size_t>(bytes)), std::move(*reserved)});
}

Result<WorkMemory> WorkMemory::make_in_file(std::uint64_t bytes, const FileUse& use, Error refusal) {
  if (bytes < use.least_bytes) return tl::unexpected(std::move(refusal));
  auto file = ScratchFile::make(bytes);
  if (file) return WorkMemory(std::move(*file));
  return refuse(bytes, use, std::move(refusal), file.error());
}

tl::unexpected<Error> WorkMemory::refuse(std::uint64_t bytes, const FileUse& use, Error refusal,
                                         const std::string& reason) {
  refusal.message += fmt::format("; {}", reason);
  refusal.hint.steps.emplace_back(
      fmt::format("set the environment variable TMPDIR to a folder on a disk with {} free, for the {}",
                  format_byte_size(std::max(bytes, use.all_bytes)), use.kind_of_data));
  return tl::unexpected(std::move(refusal));
}

std::span<std::byte> WorkMemory::bytes() {
  if (auto* reserved = std::get_if<ReservedBuffer<std::byte>>(&place_)) return reserved->values.span();
  return std::get<ScratchFile>(place_).bytes();
}

void WorkMemory::leave(std::span<const std::byte> part) const {
  if (is_in_file()) release_pages(part.data(), part.size());
}

bool WorkMemory::lost() const {
  const auto* file = std::get_if<ScratchFile>(&place_);
  return file != nullptr && file->lost();
}

void WorkMemory::protect() {
  if (auto* file = std::get_if<ScratchFile>(&place_)) file->protect();
}

}  // namespace isoextract::files

#include "volume_io/detail/sample_store.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "base/byte_size.hpp"
#include "base/pages.hpp"
#include "volume_io/detail/dense_format.hpp"

namespace isoextract::volume_io {

bool prefers_file(std::uint64_t bytes, const Context& context) {
  return bytes >= kLeastInFile && bytes > context.memory().limit() / 2;
}

int layers_at_once(std::uint64_t layer_bytes, int layers, const Context& context) {
  const std::uint64_t most = context.memory().left() / 2 / std::max<std::uint64_t>(layer_bytes, 1);
  if (most >= static_cast<std::uint64_t>(layers)) return layers;
  const int fitting = std::max(1, static_cast<int>(most));
  int unit = 64;
  while (unit > fitting) unit /= 2;
  return fitting / unit * unit;
}

Result<SampleStore> SampleStore::make(const std::string& source, const glm::ivec3& dims, field::SampleType type,
                                      const Context& context, const std::string& kind, std::uint64_t beside) {
  const std::string what = fmt::format("{}: {}{}", source, kind, describe_samples(dims, type));
  const std::uint64_t bytes = sample_bytes(dims, type);
  if (bytes >= kLeastInFile && prefers_file(bytes + beside, context)) {
    if (auto file = files::ScratchFile::make(bytes)) return SampleStore(dims, type, std::move(*file));
  }
  auto reserved = context.reserve(bytes, what);
  if (reserved) {
    try {
      return SampleStore(
          dims, type,
          ReservedBuffer<std::byte>{Buffer<std::byte>(static_cast<std::size_t>(bytes)), std::move(*reserved)});
    } catch (const std::bad_alloc&) {
      return tl::unexpected(allocation_error(
          fmt::format("{}: no memory for {} bytes of samples, neither as a mapping of the file (mmap) nor as a copy",
                      source, bytes)));
    }
  }
  return make_in_file(dims, type, std::move(reserved.error()));
}

Result<SampleStore> SampleStore::make_in_file(const glm::ivec3& dims, field::SampleType type, Error refusal) {
  const std::uint64_t bytes = sample_bytes(dims, type);
  if (bytes < kLeastInFile) return tl::unexpected(std::move(refusal));
  auto file = files::ScratchFile::make(bytes);
  if (file) return SampleStore(dims, type, std::move(*file));
  refusal.message += fmt::format("; {}", file.error());
  refusal.hint.steps.emplace_back(
      fmt::format("set the environment variable TMPDIR to a folder on a disk with {} free, for the samples",
                  format_byte_size(bytes)));
  return tl::unexpected(std::move(refusal));
}

std::span<std::byte> SampleStore::bytes() {
  if (auto* reserved = std::get_if<ReservedBuffer<std::byte>>(&memory_)) return reserved->values.span();
  return std::get<files::ScratchFile>(memory_).bytes();
}

void SampleStore::leave(std::span<const std::byte> part) const {
  if (is_in_file()) release_pages(part.data(), part.size());
}

field::DenseSamples SampleStore::finish(Notes& notes) && {
  field::DenseSamples samples;
  samples.type = type_;
  samples.dims = dims_;
  samples.data = bytes().data();
  if (auto* reserved = std::get_if<ReservedBuffer<std::byte>>(&memory_)) {
    samples.owner = std::make_shared<const ReservedBuffer<std::byte>>(std::move(*reserved));
    return samples;
  }
  std::erase_if(notes, [](const Note& note) { return note.id == NoteId::samples_in_file; });
  notes.push_back(
      {NoteId::samples_in_file, fmt::format("memory is short for the {} of samples, so they are in a temporary file",
                                            format_byte_size(bytes().size()))});
  const auto file = std::make_shared<files::ScratchFile>(std::move(std::get<files::ScratchFile>(memory_)));
  file->protect();
  samples.file_backed = true;
  samples.is_lost_on_disk = [](const void* owner) { return static_cast<const files::ScratchFile*>(owner)->lost(); };
  samples.owner = file;
  return samples;
}

}  // namespace isoextract::volume_io

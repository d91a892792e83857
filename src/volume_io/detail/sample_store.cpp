#include "volume_io/detail/sample_store.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "base/byte_size.hpp"
#include "volume_io/detail/dense_format.hpp"

namespace isoextract::volume_io {
namespace {

files::FileUse file_use(bool prefers_file) {
  return {.prefers_file = prefers_file, .least_bytes = kLeastInFile, .kind_of_data = "samples"};
}

}  // namespace

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
  try {
    auto memory = TRY(files::WorkMemory::make(bytes, file_use(prefers_file(bytes + beside, context)), context, what));
    return SampleStore(dims, type, std::move(memory));
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(
        fmt::format("{}: no memory for {} bytes of samples, neither as a mapping of the file (mmap) nor as a copy",
                    source, bytes)));
  }
}

Result<SampleStore> SampleStore::make_in_file(const glm::ivec3& dims, field::SampleType type, Error refusal) {
  auto memory = TRY(files::WorkMemory::make_in_file(sample_bytes(dims, type), file_use(true), std::move(refusal)));
  return SampleStore(dims, type, std::move(memory));
}

field::DenseSamples SampleStore::finish(Notes& notes) && {
  field::DenseSamples samples;
  samples.type = type_;
  samples.dims = dims_;
  samples.data = bytes().data();
  const auto owner = std::make_shared<files::WorkMemory>(std::move(memory_));
  samples.owner = owner;
  if (!owner->is_in_file()) return samples;
  std::erase_if(notes, [](const Note& note) { return note.id == NoteId::samples_in_file; });
  notes.push_back(
      {NoteId::samples_in_file, fmt::format("memory is short for the {} of samples, so they are in a temporary file",
                                            format_byte_size(owner->bytes().size()))});
  owner->protect();
  samples.file_backed = true;
  samples.is_lost_on_disk = [](const void* memory) { return static_cast<const files::WorkMemory*>(memory)->lost(); };
  return samples;
}

}  // namespace isoextract::volume_io

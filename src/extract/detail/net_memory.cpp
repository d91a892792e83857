#include "extract/detail/net_memory.hpp"

namespace isoextract::extract {

files::FileUse NetMemory::use(std::uint64_t bytes) const {
  return {.prefers_file = uses_files_ || prefers_files(bytes_of(false) + bytes, context_),
          .least_bytes = kLeastNetFile,
          .kind_of_data = "voxels and points of the net",
          .all_bytes = expected_bytes_};
}

std::shared_ptr<files::WorkMemory> NetMemory::keep(files::WorkMemory made) {
  auto memory = std::make_shared<files::WorkMemory>(std::move(made));
  {
    const std::lock_guard lock(mutex_);
    arrays_.push_back(memory);
  }
  const std::uint64_t now = bytes_in_files();
  std::uint64_t most = most_in_files_;
  while (now > most && !most_in_files_.compare_exchange_weak(most, now)) {
  }
  return memory;
}

std::vector<std::shared_ptr<files::WorkMemory>> NetMemory::list(bool in_files) const {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<files::WorkMemory>> alive;
  std::erase_if(arrays_, [&](const std::weak_ptr<files::WorkMemory>& one) {
    auto memory = one.lock();
    if (memory != nullptr && memory->is_in_file() == in_files) alive.push_back(std::move(memory));
    return one.expired();
  });
  return alive;
}

std::uint64_t NetMemory::bytes_of(bool in_files) const {
  std::uint64_t bytes = 0;
  for (const std::shared_ptr<files::WorkMemory>& memory : list(in_files)) bytes += memory->bytes().size();
  return bytes;
}

void NetMemory::leave() const {
  for (const std::shared_ptr<files::WorkMemory>& memory : list(true)) memory->leave(memory->bytes());
}

void NetMemory::leave_after(std::uint64_t used_bytes) const {
  if (used_bytes_.fetch_add(used_bytes) + used_bytes < run_bytes(context_) / 2) return;
  used_bytes_ = 0;
  leave();
}

std::size_t NetMemory::run_length(std::size_t count, std::uint64_t bytes) const {
  if (bytes == 0) return std::max<std::size_t>(count, 1);
  // A pass reads a layer of chunks before and after a run, too, so a short run reads most pages several times.
  constexpr std::size_t kLeast = 32;
  const auto part = static_cast<double>(run_bytes(context_)) / 2 / static_cast<double>(bytes);
  return std::max(kLeast, static_cast<std::size_t>(std::min(part, 1.0) * static_cast<double>(count)));
}

Result<void> NetMemory::check() const {
  for (const std::shared_ptr<files::WorkMemory>& memory : list(true)) {
    if (!memory->lost()) continue;
    return fail(ErrorCode::input,
                what_ + ": the disk lost a part of a temporary file, which it could not write or read",
                "set the environment variable TMPDIR to a folder on another disk");
  }
  return {};
}

}  // namespace isoextract::extract

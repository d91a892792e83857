#include "files/detail/opened_files.hpp"

#include <algorithm>
#include <utility>

#include <unistd.h>

namespace isoextract::files {

OpenFile::~OpenFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool OpenFile::take(int descriptor) {
  descriptor_ = descriptor;
  const auto version = descriptor >= 0 ? version_of(descriptor) : std::nullopt;
  version_ = version.value_or(FileVersion());
  return version.has_value();
}

std::shared_ptr<const OpenFile> OpenedFiles::find(const FileVersion& version) const {
  {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find_if(files_, [&](const auto& file) { return file->version() == version; });
    if (found != files_.end()) return *found;
  }
  return before_ ? before_->find(version) : nullptr;
}

std::shared_ptr<const OpenFile> OpenedFiles::find(const std::filesystem::path& path) const {
  const auto version = version_of(path);
  return version ? find(*version) : nullptr;
}

void OpenedFiles::add(std::shared_ptr<const OpenFile> file) {
  const std::lock_guard lock(mutex_);
  if (files_.size() == kMost) files_.erase(files_.begin());
  files_.push_back(std::move(file));
}

}  // namespace isoextract::files

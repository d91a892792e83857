#include "files/detail/opened_files.hpp"

#include <algorithm>
#include <utility>

#include <unistd.h>

namespace isoextract::files {

OpenFile::~OpenFile() {
  if (descriptor >= 0) ::close(descriptor);
}

std::shared_ptr<const OpenFile> OpenedFiles::find(const FileVersion& version) const {
  {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find_if(files_, [&](const auto& file) { return file->version == version; });
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

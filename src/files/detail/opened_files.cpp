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

void OpenedFiles::keep_streams(std::shared_ptr<ParkedStreams> streams) {
  const std::lock_guard lock(mutex_);
  streams_ = std::move(streams);
}

std::shared_ptr<ParkedStreams> OpenedFiles::streams() const {
  {
    const std::lock_guard lock(mutex_);
    if (streams_) return streams_;
  }
  return before_ ? before_->streams() : nullptr;
}

std::shared_ptr<const UnpackedFiles> OpenedFiles::find_unpacked(const FileVersion& version) const {
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [of, unpacked] : unpacked_) {
      if (of == version) return unpacked;
    }
  }
  return before_ ? before_->find_unpacked(version) : nullptr;
}

void OpenedFiles::keep_unpacked(const FileVersion& version, std::shared_ptr<const UnpackedFiles> unpacked) {
  const std::scoped_lock lock(mutex_);
  unpacked_.emplace_back(version, std::move(unpacked));
}

std::shared_ptr<OpenedFiles> opened_files_of(const Context& context) {
  return context.opened_files(
      [](std::shared_ptr<OpenedFiles> before) { return std::make_shared<OpenedFiles>(std::move(before)); });
}

}  // namespace isoextract::files

#include "zarr_store.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "zarr_zip_store.hpp"

namespace isoextract_zarr {
namespace {

class FolderValue final : public Value {
 public:
  FolderValue(File file, std::uint64_t size, std::string key)
      : Value(size), file_(std::move(file)), key_(std::move(key)) {}

 private:
  void read_checked(std::uint64_t offset, std::span<std::byte> to) const override { file_.read(offset, to, key_); }

  File file_;
  std::string key_;
};

class FolderStore final : public Store {
 public:
  explicit FolderStore(std::string root) : root_(std::move(root)) {}

  [[nodiscard]] std::unique_ptr<Value> find(const std::string& key) const override {
    File file(path_of(key));
    if (!file.is_open()) {
      // A chunk's name may be too long for the file system: then there is no such chunk.
      if (errno == ENOENT || errno == ENOTDIR || errno == ENAMETOOLONG) return nullptr;
      throw ReadError(fmt::format("cannot open '{}': {}", shown(key), std::strerror(errno)));
    }
    struct stat status {};
    if (::fstat(file.number(), &status) != 0 || S_ISDIR(status.st_mode)) return nullptr;
    if (!S_ISREG(status.st_mode)) throw ReadError(fmt::format("expected a regular file, found '{}'", shown(key)));
    const auto size = static_cast<std::uint64_t>(status.st_size);
    return std::make_unique<FolderValue>(std::move(file), size, key);
  }

  [[nodiscard]] std::vector<std::string> folders(const std::string& group) const override {
    std::vector<std::string> names;
    const std::unique_ptr<DIR, int (*)(DIR*)> folder(::opendir(path_of(group).c_str()), ::closedir);
    if (folder == nullptr) return names;
    while (const dirent* entry = ::readdir(folder.get())) {
      const std::string name = entry->d_name;
      if (name.starts_with('.')) continue;
      bool is_folder = entry->d_type == DT_DIR;
      if (entry->d_type == DT_LNK || entry->d_type == DT_UNKNOWN) {
        std::error_code failed;
        is_folder = std::filesystem::is_directory(path_of(join(group, name)), failed);
      }
      if (is_folder) names.push_back(name);
    }
    std::ranges::sort(names);
    return names;
  }

  [[nodiscard]] std::string file_of(const std::string& key) const override { return path_of(key); }

  [[nodiscard]] std::string identity(const std::string& group) const override {
    struct stat status {};
    if (::stat(path_of(group).c_str(), &status) != 0) return group;
    return fmt::format("{}:{}", status.st_dev, status.st_ino);
  }

 private:
  [[nodiscard]] std::string path_of(const std::string& key) const { return key.empty() ? root_ : root_ + '/' + key; }

  std::string root_;
};

}  // namespace

// O_NONBLOCK: opening a named pipe would wait for its writer.
File::File(const std::string& path) : number_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}

File::~File() {
  if (number_ >= 0) ::close(number_);
}

void File::read(std::uint64_t offset, std::span<std::byte> to, const std::string& key) const {
  while (!to.empty()) {
    const ssize_t got = ::pread(number_, to.data(), to.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw ReadError(fmt::format("cannot read '{}': {}", shown(key), std::strerror(errno)));
    if (got == 0) throw ReadError(fmt::format("'{}' became shorter during the read", shown(key)));
    offset += static_cast<std::uint64_t>(got);
    to = to.subspan(static_cast<std::size_t>(got));
  }
}

void Value::read(std::uint64_t offset, std::span<std::byte> to) const {
  if (offset > size_ || size_ - offset < to.size()) {
    throw ReadError(fmt::format("expected {} bytes from byte {} on, found {} bytes in all", to.size(), offset, size_));
  }
  read_checked(offset, to);
}

bool is_metadata_name(std::string_view name) {
  constexpr std::array<std::string_view, 5> kNames{"zarr.json", ".zarray", ".zgroup", ".zattrs", ".zmetadata"};
  return std::ranges::find(kNames, name) != kNames.end();
}

std::unique_ptr<Store> open_store(const std::string& path, isoextract_plugin::HostMemory& memory) {
  std::error_code failed;
  const std::filesystem::path given(path);
  if (std::filesystem::is_directory(given, failed)) return std::make_unique<FolderStore>(path);
  if (is_metadata_name(given.filename().string())) {
    const std::string folder = given.parent_path().string();
    return std::make_unique<FolderStore>(folder.empty() ? "." : folder);
  }
  return open_zip_store(path, memory);
}

std::string shown(std::string_view text) {
  constexpr std::size_t kMost = 100;
  std::string result(text.substr(0, kMost));
  std::ranges::replace_if(
      result, [](char c) { return c < ' ' || c > '~'; }, '?');
  if (text.size() > kMost) result += "...";
  return result;
}

std::string join(const std::string& group, const std::string& name) {
  if (group.empty() || name.empty()) return group + name;
  return group + '/' + name;
}

std::string checked_path(const std::string& path) {
  std::string_view rest(path);
  while (rest.starts_with('/')) rest.remove_prefix(1);
  while (rest.ends_with('/')) rest.remove_suffix(1);
  const std::string result(rest);
  while (!rest.empty()) {
    const std::string_view name = rest.substr(0, rest.find('/'));
    if (name.empty() || name == "." || name == ".." || name.find('\0') != std::string_view::npos) {
      throw ReadError(fmt::format("expected a path inside the Zarr hierarchy, found '{}'", shown(path)));
    }
    rest.remove_prefix(std::min(rest.size(), name.size() + 1));
  }
  return result;
}

}  // namespace isoextract_zarr

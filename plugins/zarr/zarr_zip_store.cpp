#include "zarr_zip_store.hpp"

#include <minizip/unzip.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>

#include <fmt/format.h>

namespace isoextract_zarr {
namespace {

using ZipFile = std::unique_ptr<void, int (*)(unzFile)>;

ZipFile open_zip(const std::string& path) { return {::unzOpen64(path.c_str()), ::unzClose}; }

struct ZipEntry {
  unz64_file_pos position{};
  std::uint64_t size = 0;
  bool is_stored = false;
  std::string problem;  // why it cannot be read; empty if it can
};

// State that all values of one ZIP file share. minizip has one position per file, so that readers take turns.
struct SharedZip {
  explicit SharedZip(const std::string& path) : file(path), zip(open_zip(path)) {}

  File file;
  ZipFile zip;
  std::mutex mutex;
};

[[noreturn]] void fail_on(const std::string& key, const std::string& what) {
  throw ReadError(fmt::format("ZIP member '{}': {}", shown(key), what));
}

class ZipValue final : public Value {
 public:
  ZipValue(SharedZip& shared, const ZipEntry& entry, std::string key)
      : Value(entry.size), shared_(shared), entry_(entry), key_(std::move(key)) {}

 private:
  void read_checked(std::uint64_t offset, std::span<std::byte> to) const override {
    const std::lock_guard lock(shared_.mutex);
    unz64_file_pos position = entry_.position;
    if (::unzGoToFilePos64(shared_.zip.get(), &position) != UNZ_OK ||
        ::unzOpenCurrentFile(shared_.zip.get()) != UNZ_OK) {
      fail_on(key_, "its header is damaged");
    }
    // Reads whole members through minizip, which verifies checksums.
    const bool is_whole = offset == 0 && to.size() == entry_.size;
    if (entry_.is_stored && !is_whole) {
      const std::uint64_t begin = ::unzGetCurrentFileZStreamPos64(shared_.zip.get());
      ::unzCloseCurrentFile(shared_.zip.get());
      shared_.file.read(begin + offset, to, key_);
      return;
    }
    const bool read_all = skip(offset) && fill(to);
    const bool is_intact = ::unzCloseCurrentFile(shared_.zip.get()) == UNZ_OK || !is_whole;
    if (!read_all || !is_intact) fail_on(key_, "it is damaged");
  }

  [[nodiscard]] bool skip(std::uint64_t bytes) const {
    std::array<std::byte, 1 << 14> unused{};
    while (bytes > 0) {
      const auto step = static_cast<std::size_t>(std::min<std::uint64_t>(bytes, unused.size()));
      if (!fill(std::span(unused).first(step))) return false;
      bytes -= step;
    }
    return true;
  }

  [[nodiscard]] bool fill(std::span<std::byte> to) const {
    constexpr std::size_t kMostAtOnce = std::size_t{1} << 30;
    while (!to.empty()) {
      const std::size_t step = std::min(to.size(), kMostAtOnce);
      const int got = ::unzReadCurrentFile(shared_.zip.get(), to.data(), static_cast<unsigned>(step));
      if (got <= 0) return false;
      to = to.subspan(static_cast<std::size_t>(got));
    }
    return true;
  }

  SharedZip& shared_;
  const ZipEntry& entry_;
  std::string key_;
};

// Returns why a member cannot be read; empty if it can.
std::string problem_of(const unz_file_info64& info, std::uint64_t file_size) {
  constexpr std::uint64_t kDeflate = 8;
  constexpr std::uint64_t kMaxDeflateRatio = 1032;
  if ((info.flag & 1) != 0) return "it is encrypted";
  if (info.compressed_size > file_size) return "it is larger than the ZIP file";
  if (info.compression_method == 0 && info.compressed_size != info.uncompressed_size) return "its sizes differ";
  if (info.compression_method != 0 && info.compression_method != kDeflate) {
    return fmt::format("expected compression method 0 (stored) or 8 (Deflate), found {}", info.compression_method);
  }
  if (info.uncompressed_size / kMaxDeflateRatio > info.compressed_size) return "its size is not possible";
  return {};
}

class ZipStore final : public Store {
 public:
  ZipStore(const std::string& path, isoextract_plugin::HostMemory& memory) : shared_(path) {
    if (shared_.zip == nullptr || !shared_.file.is_open()) throw ReadError("expected an intact ZIP file");
    std::error_code failed;
    const std::uint64_t file_size = std::filesystem::file_size(path, failed);
    read_directory(failed ? 0 : file_size, memory);
    find_root();
  }

  [[nodiscard]] std::unique_ptr<Value> find(const std::string& key) const override {
    const auto found = entries_.find(root_ + key);
    if (found == entries_.end()) return nullptr;
    if (!found->second.problem.empty()) fail_on(key, found->second.problem);
    return std::make_unique<ZipValue>(shared_, found->second, key);
  }

  [[nodiscard]] std::vector<std::string> folders(const std::string& group) const override {
    const std::string prefix = group.empty() ? root_ : root_ + group + '/';
    std::vector<std::string> names;
    auto at = entries_.lower_bound(prefix);
    while (at != entries_.end() && at->first.starts_with(prefix)) {
      const std::size_t end = at->first.find('/', prefix.size());
      if (end == std::string::npos) {
        ++at;
        continue;
      }
      names.push_back(at->first.substr(prefix.size(), end - prefix.size()));
      // Skips the members of this folder: '0' is the character after '/'.
      at = entries_.lower_bound(at->first.substr(0, end) + '0');
    }
    // Leaves out hidden names, as in a folder, and empty names.
    std::erase_if(names, [](const std::string& name) { return name.empty() || name.starts_with('.'); });
    return names;
  }

  [[nodiscard]] std::string file_of(const std::string& /*key*/) const override { return {}; }

 private:
  void read_directory(std::uint64_t file_size, isoextract_plugin::HostMemory& memory) {
    constexpr std::size_t kEntriesAtOnce = 4096;
    constexpr std::size_t kLongestName = 1024;
    constexpr std::uint64_t kEntryBytes = sizeof(ZipEntry) + 192;
    std::array<char, kLongestName + 1> name{};
    int status = ::unzGoToFirstFile(shared_.zip.get());
    for (std::size_t count = 0; status == UNZ_OK; ++count) {
      if (count % kEntriesAtOnce == 0) memory.take(kEntriesAtOnce * kEntryBytes);
      unz_file_info64 info{};
      if (::unzGetCurrentFileInfo64(shared_.zip.get(), &info, name.data(), kLongestName, nullptr, 0, nullptr, 0) !=
          UNZ_OK) {
        break;
      }
      ZipEntry entry;
      entry.size = info.uncompressed_size;
      entry.is_stored = info.compression_method == 0;
      entry.problem = problem_of(info, file_size);
      if (::unzGetFilePos64(shared_.zip.get(), &entry.position) != UNZ_OK) break;
      if (info.size_filename < kLongestName) entries_[name.data()] = std::move(entry);
      status = ::unzGoToNextFile(shared_.zip.get());
    }
    if (status != UNZ_END_OF_LIST_OF_FILE) throw ReadError("the directory of the ZIP file is damaged");
  }

  // Finds a hierarchy that was packed together with its folder.
  void find_root() {
    const auto has_metadata = [&](const std::string& prefix) {
      for (const char* name : {"zarr.json", ".zarray", ".zgroup", ".zmetadata"}) {
        if (entries_.contains(prefix + name)) return true;
      }
      return false;
    };
    if (has_metadata("")) return;
    const auto below = folders("");
    if (below.size() == 1 && has_metadata(below.front() + '/')) root_ = below.front() + '/';
  }

  mutable SharedZip shared_;
  std::map<std::string, ZipEntry> entries_;
  std::string root_;
};

}  // namespace

std::unique_ptr<Store> open_zip_store(const std::string& path, isoextract_plugin::HostMemory& memory) {
  return std::make_unique<ZipStore>(path, memory);
}

bool zip_has_metadata(const std::string& path) {
  const ZipFile zip = open_zip(path);
  if (zip == nullptr) return false;
  std::array<char, 1025> name{};
  constexpr int kMostLookedAt = 100000;
  int left = kMostLookedAt;
  for (int status = ::unzGoToFirstFile(zip.get()); status == UNZ_OK && left > 0;
       status = ::unzGoToNextFile(zip.get()), --left) {
    if (::unzGetCurrentFileInfo64(zip.get(), nullptr, name.data(), name.size() - 1, nullptr, 0, nullptr, 0) != UNZ_OK) {
      return false;
    }
    const std::string_view whole(name.data());
    if (is_metadata_name(whole.substr(whole.rfind('/') + 1))) return true;
  }
  return false;
}

}  // namespace isoextract_zarr

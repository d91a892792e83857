// Unpacks a compressed file or an archive with libarchive (gzip: zlib). The first grid (u8) holds the bytes of all
// files in order. One more grid per file states the file's name and size, and cannot be read.
//
// Sizes are counted by unpacking, because archives may state other sizes than their files have, and compressed files
// state none. Nothing is kept in memory between the list and the reading.
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <archive.h>
#include <archive_entry.h>
#include <zlib.h>

#include "decoder_window.hpp"
#include "volume_reader.hpp"

namespace {

using isoextract_plugin::check_cancelled;
using isoextract_plugin::Grid;
using isoextract_plugin::HostMemory;
using isoextract_plugin::ReadError;
using isoextract_plugin::ReadFacts;
using isoextract_plugin::Request;
using isoextract_plugin::VolumeFile;

constexpr std::size_t kPart = std::size_t{1} << 20;
// What the decoders need for small windows: those of gzip and bzip2, and xz and zstd at low levels.
constexpr std::uint64_t kDecoderBytes = std::uint64_t{16} << 20;
constexpr std::uint64_t kBufferBytes = std::uint64_t{4} << 20;  // of this, all but the window
constexpr std::size_t kMaxFiles = 100000;

struct ArchiveDeleter {
  void operator()(archive* opened) const { archive_read_free(opened); }
};
using Archive = std::unique_ptr<archive, ArchiveDeleter>;

std::string reason_of(archive* opened) {
  const char* text = archive_error_string(opened);
  return text != nullptr ? text : "the library gave no reason";
}

// Reserves the memory of a file's decoder in the host as its window fills. The windows of xz -9 (64 MiB) and of zstd
// --ultra -22 (128 MiB) stay mostly unused if the file is small.
class DecoderMemory {
 public:
  DecoderMemory(const std::string& path, const isoextract_plugin_host& host)
      : memory_(host), window_(isoextract_archive::stated_window(path)) {
    memory_.take(taken_);
  }

  // Reserves what the decoder needs to unpack `bytes` in total.
  void take_for(std::uint64_t bytes) {
    const std::uint64_t needed = kBufferBytes + std::min(window_, bytes);
    if (needed <= taken_) return;
    memory_.take(needed - taken_);
    taken_ = needed;
  }

  [[nodiscard]] std::uint64_t window() const { return window_; }

 private:
  HostMemory memory_;
  std::uint64_t window_;
  std::uint64_t taken_ = kDecoderBytes;
};

void check(archive* opened, int status, const char* what, DecoderMemory& memory) {
  if (status == ARCHIVE_OK || status == ARCHIVE_WARN) return;
  const std::string reason = reason_of(opened);
  // libarchive has no error code for a window of zstd that the system refuses, or that zstd refuses for its size.
  if (archive_errno(opened) == ENOMEM || reason.find("not enough memory") != std::string::npos) {
    memory.take_for(memory.window());  // throws with the host's message if the memory limit is the reason
    throw std::bad_alloc();
  }
  if (reason.find("too much memory") != std::string::npos) {
    throw ReadError("expected a window that the library accepts, found one of " +
                    std::to_string(memory.window() >> 20U) + " MiB: " + reason);
  }
  throw ReadError(std::string("expected ") + what + ", found damaged data: " + reason);
}

bool is_zip(const std::string& path) {
  std::array<char, 2> start{};
  return std::ifstream(path, std::ios::binary).read(start.data(), start.size()) && start == std::array{'P', 'K'};
}

enum class Content { raw, tar };

Archive open_archive(const std::string& path, Content content, DecoderMemory& memory) {
  Archive opened(archive_read_new());
  if (!opened) throw std::bad_alloc();
  if (is_zip(path)) {
    // Does not enable the raw format: libarchive would take a truncated zip file for raw content.
    archive_read_support_format_zip_seekable(opened.get());
  } else {
    archive_read_support_filter_gzip(opened.get());
    archive_read_support_filter_xz(opened.get());
    archive_read_support_filter_zstd(opened.get());
    archive_read_support_filter_bzip2(opened.get());
    // Enables one format only: libarchive takes content that begins with zeros for an empty tar archive.
    if (content == Content::tar) archive_read_support_format_tar(opened.get());
    if (content == Content::raw) archive_read_support_format_raw(opened.get());
  }
  check(opened.get(), archive_read_open_filename(opened.get(), path.c_str(), kPart), "a compressed file or an archive",
        memory);
  return opened;
}

// Returns `tar` if the unpacked content has tar's signature, else `raw`; zip files need neither.
Content content_of(const std::string& path, DecoderMemory& memory) {
  if (is_zip(path)) return Content::raw;
  const Archive opened = open_archive(path, Content::raw, memory);
  archive_entry* entry = nullptr;
  check(opened.get(), archive_read_next_header(opened.get(), &entry), "the start of a file", memory);
  constexpr std::size_t kTarHeader = 512;
  std::array<char, kTarHeader> start{};
  const la_ssize_t got = archive_read_data(opened.get(), start.data(), start.size());
  const bool is_whole = got == static_cast<la_ssize_t>(kTarHeader);
  return is_whole && std::string_view(start.data() + 257, 5) == "ustar" ? Content::tar : Content::raw;
}

struct GzipDeleter {
  void operator()(gzFile opened) const { gzclose(opened); }
};
using Gzip = std::unique_ptr<gzFile_s, GzipDeleter>;

// Returns the file if it is gzip around anything but a tar archive; null otherwise. zlib reads such files, because
// libarchive does not check gzip's checksums.
Gzip open_gzip(const std::string& path) {
  std::array<char, 2> magic{};
  std::ifstream(path, std::ios::binary).read(magic.data(), magic.size());
  if (magic != std::array{'\x1f', '\x8b'}) return nullptr;
  Gzip opened(gzopen(path.c_str(), "rb"));
  if (!opened) throw std::bad_alloc();
  constexpr int kTarHeader = 512;
  std::array<char, kTarHeader> start{};
  const bool is_tar = gzread(opened.get(), start.data(), kTarHeader) == kTarHeader &&
                      std::string_view(start.data() + 257, 5) == "ustar";
  if (is_tar) return nullptr;
  gzrewind(opened.get());
  return opened;
}

template <class OnBytes>
void read_gzip(const std::string& path, gzFile opened, const isoextract_plugin_host& host, OnBytes&& bytes) {
  std::vector<char> part(kPart);
  for (;;) {
    check_cancelled(host);
    const int got = gzread(opened, part.data(), static_cast<unsigned>(part.size()));
    if (got > 0) bytes(part.data(), static_cast<std::uint64_t>(got));
    if (got == static_cast<int>(part.size())) continue;
    int status = Z_OK;
    std::string text = gzerror(opened, &status);
    if (text.starts_with(path + ": ")) text.erase(0, path.size() + 2);
    if (got < 0 || status != Z_OK) throw ReadError("expected whole gzip data, found damaged data: " + text);
    return;
  }
}

// Calls file(name) at the start of each regular file, and bytes(data, count) for its content in order.
template <class OnFile, class OnBytes>
void walk(const std::string& path, const isoextract_plugin_host& host, OnFile&& file, OnBytes&& bytes) {
  DecoderMemory memory(path, host);
  if (const Gzip packed = open_gzip(path)) {
    file(std::string());
    read_gzip(path, packed.get(), host, bytes);
    return;
  }
  const Archive opened = open_archive(path, content_of(path, memory), memory);
  std::vector<char> part(kPart);
  std::uint64_t unpacked = 0;
  archive_entry* entry = nullptr;
  for (;;) {
    check_cancelled(host);
    const int status = archive_read_next_header(opened.get(), &entry);
    if (status == ARCHIVE_EOF) return;
    check(opened.get(), status, "the start of a file", memory);
    if (archive_entry_filetype(entry) != AE_IFREG || archive_entry_hardlink(entry) != nullptr) continue;
    if (archive_entry_is_encrypted(entry) != 0)
      throw ReadError("expected files without a password, found an encrypted one");
    const char* name = archive_entry_pathname_utf8(entry);
    if (name == nullptr) name = archive_entry_pathname(entry);
    const bool is_raw = archive_format(opened.get()) == ARCHIVE_FORMAT_RAW;
    file(std::string(name == nullptr || is_raw ? "" : name));
    for (;;) {
      memory.take_for(unpacked + kPart);
      const la_ssize_t got = archive_read_data(opened.get(), part.data(), part.size());
      if (got == 0) break;
      if (got < 0) check(opened.get(), ARCHIVE_FAILED, "whole content", memory);  // a zip's wrong checksum is a warning
      unpacked += static_cast<std::uint64_t>(got);
      bytes(part.data(), static_cast<std::uint64_t>(got));
      check_cancelled(host);
    }
  }
}

Grid grid_of_bytes(std::string name) {
  Grid grid;
  grid.name = std::move(name);
  grid.type_name = "bytes";
  grid.sample_type = ISOEXTRACT_U8;
  grid.dims = {0, 1, 1};
  return grid;
}

class ArchiveFile final : public VolumeFile {
 public:
  ArchiveFile(std::string path, const isoextract_plugin_host& host) : path_(std::move(path)) {
    grids.push_back(grid_of_bytes(""));
    walk(
        path_, host,
        [&](std::string name) {
          if (grids.size() > kMaxFiles) {
            throw ReadError("expected at most " + std::to_string(kMaxFiles) + " files, found more");
          }
          grids.push_back(grid_of_bytes(std::move(name)));
        },
        [&](const char*, std::uint64_t count) {
          grids.back().dims[0] += count;
          grids.front().dims[0] += count;
        });
    if (grids.size() == 1) throw ReadError("expected at least one file, found none");
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    const std::uint64_t all = grids.front().dims[0];
    if (selection.grid != 0 || selection.count[0] != all) throw ReadError("expected a request for all files together");
    auto* const to = static_cast<char*>(selection.box);
    std::uint64_t filled = 0;
    walk(
        path_, host, [](const std::string&) {},
        [&](const char* data, std::uint64_t count) {
          if (count > all - filled) throw ReadError("the file changed during the run");
          std::copy_n(data, count, to + filled);
          filled += count;
        });
    if (filled != all) throw ReadError("the file changed during the run");
    return {};
  }

 private:
  std::string path_;
};

std::unique_ptr<VolumeFile> open(const Request& request, const isoextract_plugin_host& host) {
  return std::make_unique<ArchiveFile>(request.path, host);
}

// The host chooses the files.
bool probe(const unsigned char* /*start*/, std::size_t /*bytes*/, const std::string& /*path*/) { return true; }

const isoextract_volume_plugin_v4 kPlugin = isoextract_plugin::volume_plugin<open, probe>("archive", "archive");

}  // namespace

const isoextract_volume_plugin_v4* isoextract_volume_plugin(void) { return &kPlugin; }

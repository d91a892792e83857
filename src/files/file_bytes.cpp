#include "files/file_bytes.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include "files/detail/opened_files.hpp"
#include "files/detail/standard_input.hpp"
#include "files/detail/unpacked_paths.hpp"

namespace isoextract::files {
namespace {

std::string system_message(int error) { return std::generic_category().message(error); }

}  // namespace

bool is_standard_input(const std::filesystem::path& path) { return path == "-"; }

std::string input_label(const std::filesystem::path& path) {
  if (is_standard_input(path)) return std::string(kStandardInputName);
  const auto place = packed_place(path);
  if (!place) return path.string();
  const std::string source = input_label(place->source);
  return place->is_only_file || place->member.empty() ? source : source + "/" + place->member;
}

Result<InputFile> InputFile::open(const std::filesystem::path& path, const Context& context) {
  const auto opened = opened_files_of(context);
  const bool is_stdin = is_standard_input(path);
  if (!is_stdin) {
    if (auto file = opened->find(path)) return InputFile(path, std::move(file), context);
  }
  const std::string name = input_label(path);
  const auto cannot_read = [&](int error) {
    return fail(ErrorCode::input, fmt::format("{}: cannot read the file: {}", name, system_message(error)));
  };
  const auto file = std::make_shared<OpenFile>();  // allocated first: a later failure would leak the descriptor
  if (is_stdin) {
    file->descriptor = TRY(detail::open_standard_input(context));
  } else {
    // Without O_NONBLOCK, opening a pipe without a writer would block forever.
    file->descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  }
  struct stat status {};
  if (file->descriptor < 0 || ::fstat(file->descriptor, &status) != 0) return cannot_read(errno);
  file->version = version_of(status);
  if (S_ISDIR(status.st_mode)) return fail(ErrorCode::input, name + ": expected a file, found a folder");
  if (!S_ISREG(status.st_mode)) {
    return fail(ErrorCode::input, name + ": expected a regular file, found a pipe or device",
                "write the data to a file first");
  }
  if (status.st_size == 0) return fail(ErrorCode::input, name + (is_stdin ? ": it is empty" : ": the file is empty"));
  if (!is_stdin) opened->add(file);
  return InputFile(path, file, context);
}

InputFile::InputFile(std::filesystem::path path, std::shared_ptr<const OpenFile> file, Context context)
    : context_(std::move(context)), path_(std::move(path)), file_(std::move(file)), size_(file_->version.bytes) {}

const FileVersion& InputFile::version() const { return file_->version; }

int InputFile::descriptor() const { return file_->descriptor; }

Result<void> InputFile::read_at(std::uint64_t offset, std::span<std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(descriptor(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      return fail(ErrorCode::input,
                  fmt::format("{}: reading from byte {} failed: {}", name(), offset, system_message(errno)));
    }
    if (got == 0) {
      return fail(ErrorCode::input,
                  fmt::format("{}: the file ends at byte {}, expected {} more bytes", name(), offset, bytes.size()));
    }
    add_bytes_read(static_cast<std::uint64_t>(got));
    offset += static_cast<std::uint64_t>(got);
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return {};
}

void InputFile::add_bytes_read(std::uint64_t bytes) const {
  context_.counters().bytes_read.fetch_add(bytes, std::memory_order_relaxed);
}

bool is_gzip(std::span<const std::byte> content) {
  return content.size() >= 2 && content[0] == std::byte{0x1f} && content[1] == std::byte{0x8b};
}

Result<std::vector<std::byte>> first_bytes(const InputFile& file, std::size_t count) {
  std::vector<std::byte> bytes(std::min<std::uint64_t>(count, file.size()));
  TRY(file.read_at(0, bytes));
  if (!is_gzip(bytes)) return bytes;

  // A small file can decompress to more, so the result has room for all of `count`.
  bytes.resize(count);
  std::vector<std::byte> packed(std::min<std::uint64_t>(file.size(), 2 * count + 1024));
  TRY(file.read_at(0, packed));
  z_stream stream{};
  constexpr int kGzipOnly = 16 + MAX_WBITS;
  if (::inflateInit2(&stream, kGzipOnly) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, decltype(&::inflateEnd)> end(&stream, &::inflateEnd);
  stream.next_in = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  // Keeps the bytes that were decompressed; a damaged stream is reported when its samples are read.
  static_cast<void>(::inflate(&stream, Z_SYNC_FLUSH));
  bytes.resize(bytes.size() - stream.avail_out);
  return bytes;
}

Result<std::filesystem::path> resolve_beside(const std::filesystem::path& header, const std::string& data_file) {
  namespace fs = std::filesystem;
  const auto names =
      fmt::format("{}: the header names the data file '{}'", input_label(header), printable(data_file, 200));
  if (is_standard_input(header)) {
    return fail(ErrorCode::input, names + ", but a header from standard input has no folder in which to find it",
                "give the path of the header file");
  }
  const auto outside = [&] {
    return fail(ErrorCode::input, names + ", which is outside the folder of the header",
                "put the data file into the header's folder and write its new name into the header");
  };
  const auto is_within = [](const fs::path& folder, const fs::path& path) {
    return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
  };

  const auto place = packed_place(header);
  if (place && place->is_only_file) return resolve_beside(place->source, data_file);
  std::error_code error;
  const fs::path folder = fs::canonical(header.has_parent_path() ? header.parent_path() : fs::path("."), error);
  if (error) return fail(ErrorCode::input, fmt::format("{}: {}", header.string(), error.message()));
  // Rejects relative names that lead outside before the file system is accessed.
  const fs::path named = folder / data_file;
  if (fs::path(data_file).is_relative() && !is_within(folder, named.lexically_normal())) return outside();
  // Members of an archive are links to memory, which has no path to resolve.
  if (place && fs::exists(named.lexically_normal())) return named.lexically_normal();
  const fs::path resolved = fs::canonical(named, error);
  if (error) return fail(ErrorCode::input, fmt::format("{}, but finding it failed: {}", names, error.message()));
  if (!is_within(folder, resolved)) return outside();
  return resolved;
}

}  // namespace isoextract::files

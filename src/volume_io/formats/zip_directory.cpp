#include "volume_io/formats/zip_directory.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include <fmt/format.h>

#include "base/printable.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::uint32_t kLocalHeader = 0x04034b50;
constexpr std::uint32_t kDirectoryEntry = 0x02014b50;
constexpr std::uint32_t kDirectoryEnd = 0x06054b50;
constexpr std::uint32_t kZip64End = 0x06064b50;
constexpr std::uint32_t kZip64Locator = 0x07064b50;
constexpr std::uint64_t kEndBytes = 22;
constexpr std::uint64_t kLocatorBytes = 20;
constexpr std::uint64_t kZip64EndBytes = 56;
constexpr std::uint64_t kEntryBytes = 46;
constexpr std::uint64_t kLocalBytes = 30;
constexpr std::uint64_t kMaxComment = 0xffff;
constexpr std::uint64_t kMaxDirectory = std::uint64_t{64} << 20;
constexpr std::uint32_t kIn64Bits = 0xffffffff;  // the value is in the ZIP64 field

// Reads a little-endian number on any machine.
template <class T>
T number_at(std::span<const std::byte> bytes, std::size_t at) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value = static_cast<T>(value | static_cast<T>(std::to_integer<T>(bytes[at + i]) << (8 * i)));
  }
  return value;
}

struct Directory {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};

tl::unexpected<Error> damaged(const files::InputFile& file, const std::string& what) {
  return fail(ErrorCode::input, fmt::format("{}: not an intact ZIP file: {}", file.name(), what));
}

// Searches backward from the end of the file, as a comment of any length may follow the directory's end record.
Result<Directory> find_directory(const files::InputFile& file) {
  if (file.size() < kEndBytes) return damaged(file, fmt::format("it has {} bytes", file.size()));
  const std::uint64_t looked_at = std::min(file.size(), kEndBytes + kMaxComment + kLocatorBytes);
  std::vector<std::byte> tail(static_cast<std::size_t>(looked_at));
  const std::uint64_t tail_offset = file.size() - looked_at;
  TRY(file.read_at(tail_offset, tail));
  std::size_t at = tail.size() - kEndBytes;
  while (number_at<std::uint32_t>(tail, at) != kDirectoryEnd ||
         at + kEndBytes + number_at<std::uint16_t>(tail, at + 20) != tail.size()) {
    if (at == 0) return damaged(file, "there is no directory at its end");
    --at;
  }
  Directory directory{number_at<std::uint32_t>(tail, at + 16), number_at<std::uint32_t>(tail, at + 12)};
  const bool has_locator = at >= kLocatorBytes && number_at<std::uint32_t>(tail, at - kLocatorBytes) == kZip64Locator;
  if (has_locator && (directory.offset == kIn64Bits || directory.bytes == kIn64Bits ||
                      number_at<std::uint16_t>(tail, at + 10) == 0xffff)) {
    const std::uint64_t end = number_at<std::uint64_t>(tail, at - kLocatorBytes + 8);
    std::array<std::byte, kZip64EndBytes> record{};
    if (end > file.size() || file.size() - end < record.size())
      return damaged(file, "its ZIP64 record is outside the file");
    TRY(file.read_at(end, record));
    if (number_at<std::uint32_t>(record, 0) != kZip64End) return damaged(file, "it has no ZIP64 record");
    directory = {number_at<std::uint64_t>(record, 48), number_at<std::uint64_t>(record, 40)};
  }
  if (directory.offset > file.size() || file.size() - directory.offset < directory.bytes) {
    return damaged(file, fmt::format("its directory has {} bytes from byte {} on, the file has {}", directory.bytes,
                                     directory.offset, file.size()));
  }
  if (directory.bytes > kMaxDirectory) {
    return damaged(file,
                   fmt::format("expected a directory of at most {} bytes, found {}", kMaxDirectory, directory.bytes));
  }
  return directory;
}

// Reads the 64-bit values for fields that overflowed, in the order of the standard. Returns false if one is missing.
bool take_zip64(std::span<const std::byte> extra, ZipMember& member) {
  std::array<std::uint64_t*, 3> places{};
  std::size_t missing = 0;
  for (std::uint64_t* place : {&member.sizes.inflated, &member.sizes.packed, &member.header}) {
    if (*place == kIn64Bits) places[missing++] = place;
  }
  if (missing == 0) return true;
  while (extra.size() >= 4) {
    const auto id = number_at<std::uint16_t>(extra, 0);
    const std::size_t bytes = number_at<std::uint16_t>(extra, 2);
    if (extra.size() - 4 < bytes) return false;
    if (id == 1) {
      if (bytes < 8 * missing) return false;
      for (std::size_t i = 0; i < missing; ++i) *places[i] = number_at<std::uint64_t>(extra, 4 + 8 * i);
      return true;
    }
    extra = extra.subspan(4 + bytes);
  }
  return false;
}

}  // namespace

Result<std::vector<ZipMember>> read_zip_directory(const files::InputFile& file) {
  const auto directory = TRY(find_directory(file));
  const auto memory = TRY(file.context().reserve(directory.bytes, file.name() + ": the directory of a ZIP file"));
  std::vector<std::byte> bytes(static_cast<std::size_t>(directory.bytes));
  if (!bytes.empty()) {
    TRY(file.read_at(directory.offset, bytes));
  }
  std::vector<ZipMember> members;
  std::span<const std::byte> rest(bytes);
  while (!rest.empty()) {
    if (rest.size() < kEntryBytes || number_at<std::uint32_t>(rest, 0) != kDirectoryEntry) {
      return damaged(file, fmt::format("entry {} of its directory has no signature", members.size()));
    }
    const std::size_t name = number_at<std::uint16_t>(rest, 28);
    const std::size_t extra = number_at<std::uint16_t>(rest, 30);
    const std::size_t comment = number_at<std::uint16_t>(rest, 32);
    if (rest.size() - kEntryBytes < name + extra + comment) {
      return damaged(file, fmt::format("entry {} of its directory is truncated", members.size()));
    }
    ZipMember member;
    member.encrypted = (number_at<std::uint16_t>(rest, 8) & 1) != 0;
    member.method = number_at<std::uint16_t>(rest, 10);
    member.sizes = {number_at<std::uint32_t>(rest, 20), number_at<std::uint32_t>(rest, 24),
                    number_at<std::uint32_t>(rest, 16)};
    member.header = number_at<std::uint32_t>(rest, 42);
    member.name.assign(reinterpret_cast<const char*>(rest.data()) + kEntryBytes, name);
    if (!take_zip64(rest.subspan(kEntryBytes + name, extra), member)) {
      return damaged(file, fmt::format("'{}' lacks its sizes of 64 bits", printable(member.name, 100)));
    }
    members.push_back(std::move(member));
    rest = rest.subspan(kEntryBytes + name + extra + comment);
  }
  return members;
}

Result<SamplePiece> find_member_bytes(const files::InputFile& file, const ZipMember& member) {
  const std::string name = printable(member.name, 100);
  if (member.encrypted) return fail(ErrorCode::input, fmt::format("{}: '{}' is encrypted", file.name(), name));
  constexpr int kStored = 0;
  constexpr int kDeflate = 8;
  if (member.method != kStored && member.method != kDeflate) {
    return fail(ErrorCode::input, fmt::format("{}: '{}' has compression method {}, expected 0 (stored) or 8 (Deflate)",
                                              file.name(), name, member.method));
  }
  std::array<std::byte, kLocalBytes> local{};
  if (member.header > file.size() || file.size() - member.header < local.size()) {
    return damaged(file, fmt::format("'{}' begins after the end of the file", name));
  }
  TRY(file.read_at(member.header, local));
  if (number_at<std::uint32_t>(local, 0) != kLocalHeader) {
    return damaged(file, fmt::format("its directory gives a wrong position for '{}'", name));
  }
  const std::uint64_t begin = member.header + kLocalBytes + number_at<std::uint16_t>(local, 26) +
                              std::uint64_t{number_at<std::uint16_t>(local, 28)};
  if (begin > file.size() || file.size() - begin < member.sizes.packed) {
    return damaged(file, fmt::format("'{}' has {} bytes from byte {} on, the file has {}", name, member.sizes.packed,
                                     begin, file.size()));
  }
  SamplePiece piece{file.path(), begin};
  if (member.method == kDeflate) {
    piece.deflated = member.sizes;
  } else {
    if (member.sizes.packed != member.sizes.inflated) {
      return damaged(file, fmt::format("'{}' has method 0 (stored), but {} stored bytes for {} bytes of content", name,
                                       member.sizes.packed, member.sizes.inflated));
    }
    piece.end = begin + member.sizes.packed;
  }
  return piece;
}

Result<std::vector<std::byte>> first_bytes_of(const files::InputFile& file, const SamplePiece& piece,
                                              std::size_t count) {
  const std::uint64_t held = piece.deflated ? piece.deflated->inflated : *piece.end - piece.offset;
  std::vector<std::byte> bytes(static_cast<std::size_t>(std::min<std::uint64_t>(count, held)));
  if (!piece.deflated) {
    TRY(file.read_at(piece.offset, bytes));
    return bytes;
  }
  DeflateStream stream(file, piece.offset, *piece.deflated);
  const auto got = TRY(stream.inflate(bytes));
  bytes.resize(got);
  return bytes;
}

}  // namespace isoextract::volume_io

// Input files as bytes: opening, reading, gzip detection, and resolving data files that a header names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/printable.hpp"
#include "files/file_version.hpp"

namespace isoextract::files {

// Returns whether the input path is "-", which means standard input. To read a file named "-", give "./-".
[[nodiscard]] bool is_standard_input(const std::filesystem::path& path);
inline constexpr std::string_view kStandardInputName = "standard input";
// Returns the name of an input for messages. An unpacked file is named ARCHIVE/MEMBER, or as its compressed file.
[[nodiscard]] std::string input_label(const std::filesystem::path& path);

struct OpenFile;  // detail/opened_files.hpp

// An open, regular, non-empty file. Its errors are ErrorCode::input and start with its name. Adds the bytes it reads to
// the counter of the context in which it was opened.
class InputFile {
 public:
  // Opens a file. Reuses a file that is already open in the context, unless it was written to since.
  //
  // The first call for standard input copies it to memory, where it stays until the process ends, so that later calls
  // can open it again. The copy is reserved in the context of the first call. No copy is made if standard input is a
  // regular file at offset 0. Fails with ErrorCode::usage if standard input is a terminal.
  [[nodiscard]] static Result<InputFile> open(const std::filesystem::path& path, const Context& context);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::string name() const { return input_label(path_); }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] const FileVersion& version() const;  // at the time of opening
  // Returns the descriptor. Other InputFiles may share it: do not seek or close it.
  [[nodiscard]] int descriptor() const;
  [[nodiscard]] const Context& context() const { return context_; }

  // Fills all of `bytes` from byte `offset` of the file. Safe to call from several threads.
  [[nodiscard]] Result<void> read_at(std::uint64_t offset, std::span<std::byte> bytes) const;

  // Counts bytes that were read without read_at(). For compressed data, counts the compressed bytes.
  void add_bytes_read(std::uint64_t bytes) const;

 private:
  InputFile(std::filesystem::path path, std::shared_ptr<const OpenFile> file, Context context);

  Context context_;
  std::filesystem::path path_;
  std::shared_ptr<const OpenFile> file_;
  std::uint64_t size_ = 0;
};

[[nodiscard]] bool is_gzip(std::span<const std::byte> content);

// Returns the first bytes of the content, at most `count`, decompressed if the file is gzip. Returns fewer if the
// content is shorter or cannot be decompressed.
[[nodiscard]] Result<std::vector<std::byte>> first_bytes(const InputFile& file, std::size_t count);

// Returns the path of a data file that a header names. Fails with ErrorCode::input if the file does not exist, or if it
// lies neither in the header's folder nor below it after resolving links and "..": a header must not open arbitrary
// files. A header from standard input has no folder, so the call always fails. The folder of a header that was unpacked
// from a compressed file is the folder of that file; from an archive, it is the header's folder in the archive.
[[nodiscard]] Result<std::filesystem::path> resolve_beside(const std::filesystem::path& header,
                                                           const std::string& data_file);

using isoextract::printable;  // escapes bytes of a file for messages

}  // namespace isoextract::files

// Files as bytes: opening with clear messages, the first bytes, and where a header may point to.
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

namespace isoextract::files {

// "-" as the path of an input is standard input; a file of that name is "./-".
[[nodiscard]] bool is_standard_input(const std::filesystem::path& path);
inline constexpr std::string_view kStandardInputName = "standard input";
// What messages call an input.
[[nodiscard]] std::string shown_input_name(const std::filesystem::path& path);

struct OpenFile;  // detail/opened_files.hpp

// An open, regular file with at least one byte. Its errors are ErrorCode::input and start with its name. What is read
// of it counts in the context that it was opened in.
class InputFile {
 public:
  // A file that is open in the context already is not opened again, unless it was written to meanwhile.
  //
  // Standard input is read to its end when it is opened first, unless it is a file, and kept until the process ends: so
  // it can be opened again like any file. What is kept is reserved in the context that it was opened in first; a
  // terminal is ErrorCode::usage.
  [[nodiscard]] static Result<InputFile> open(const std::filesystem::path& path, const Context& context);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::string name() const { return shown_input_name(path_); }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  // Others may have it too: nobody moves its place, or closes it.
  [[nodiscard]] int descriptor() const;
  [[nodiscard]] const Context& context() const { return context_; }

  // Fills all of `bytes` with what lies from `offset` on. Safe to call from several threads.
  [[nodiscard]] Result<void> read_at(std::uint64_t offset, std::span<std::byte> bytes) const;

  // For what goes past read_at. Packed bytes count as they lie in the file.
  void count_bytes_read(std::uint64_t bytes) const;

 private:
  InputFile(std::filesystem::path path, std::shared_ptr<const OpenFile> file, Context context);

  Context context_;
  std::filesystem::path path_;
  std::shared_ptr<const OpenFile> file_;
  std::uint64_t size_ = 0;
};

[[nodiscard]] bool is_gzip(std::span<const std::byte> content);

// At most `count` bytes from the start of the content, inflated where the file is gzip. Fewer where the content is
// shorter or cannot be inflated.
[[nodiscard]] Result<std::vector<std::byte>> first_bytes(const InputFile& file, std::size_t count);

// The path of a data file that a header names. Fails with ErrorCode::input where it does not exist, or where it lies
// neither beside nor below the header once links and ".." are resolved: a header must not reach for other files. A
// header from standard input lies nowhere.
[[nodiscard]] Result<std::filesystem::path> resolve_beside(const std::filesystem::path& header,
                                                           const std::string& data_file);

using isoextract::printable;  // what is shown of a file's bytes

}  // namespace isoextract::files

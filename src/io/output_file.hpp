// Output that is whole or not there: bytes go to an unnamed or temporary file in the target's folder, and only
// commit() gives them the target's name. Destroying an OutputFile that was not committed leaves nothing behind.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract {

class OutputFile {
 public:
  // `path` may name a regular file (replaced on commit, through symbolic links), something that does not exist yet, or
  // a device or pipe (written directly). "-" is standard output. Fails with ErrorKind::output.
  [[nodiscard]] static Result<OutputFile> create(const std::filesystem::path& path);

  OutputFile(OutputFile&&) noexcept;
  OutputFile& operator=(OutputFile&&) noexcept;
  ~OutputFile();

  // Buffered; large spans go to the system without a copy. After a failure every later call fails alike.
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> write(std::string_view text);

  [[nodiscard]] std::uint64_t bytes_written() const;

  // Flushes and gives the file its name. Call once, last.
  [[nodiscard]] Result<void> commit();

 private:
  struct State;
  explicit OutputFile(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isoextract

// Names of files that are not finished: gone with their owner, with a process that a signal ends, and, where neither
// was possible, with the next run into that folder.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace isoextract::files {

class TemporaryName {
 public:
  // Both lock the file as long as the name stands, by which others see that it has an owner, and remove before, once a
  // process and folder, what processes that are gone left there. Nothing, with errno set, where they fail.
  // A new file in `folder`, open for reading and writing, of its own name.
  struct File;
  [[nodiscard]] static std::optional<File> make_file(const std::filesystem::path& folder);
  // A new name for an open file without one (O_TMPFILE).
  [[nodiscard]] static std::optional<TemporaryName> name_file(const std::filesystem::path& folder, int fd);

  // A second name for the file `path`. Nothing with errno set.
  [[nodiscard]] static std::optional<TemporaryName> name_again(const std::filesystem::path& folder,
                                                               const std::filesystem::path& path);

  TemporaryName() = default;
  TemporaryName(TemporaryName&& other) noexcept;
  TemporaryName& operator=(TemporaryName&& other) noexcept;
  ~TemporaryName();  // removes the file of that name

  [[nodiscard]] bool empty() const { return name_ == nullptr; }
  [[nodiscard]] const char* c_str() const { return name_->c_str(); }
  // The file stays, under this name.
  void keep();
  // Whether the file got its last name `target`, with errno set where not.
  [[nodiscard]] bool rename_to(const std::filesystem::path& target);

  // Removes all there are; no more are made in this process. For signal handlers: async-signal-safe, and to be called
  // while the signals that lead here are not blocked in all other threads.
  static void remove_all() noexcept;

 private:
  template <class Make>
  static std::optional<TemporaryName> make(const std::filesystem::path& folder, Make make);
  // Leaves this without a name. Nothing where there was none, or a handler removes the file.
  std::unique_ptr<const std::string> take() noexcept;

  std::unique_ptr<const std::string> name_;
  int slot_ = -1;  // where handlers find it
  int lock_ = -1;
};

struct TemporaryName::File {
  TemporaryName name;
  int fd = -1;  // the caller's to close
};

}  // namespace isoextract::files

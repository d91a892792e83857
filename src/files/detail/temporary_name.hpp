// Names of unfinished files. The destructor, or the handler of a signal that ends the process, removes the named file;
// if neither could run, the next run that writes into the folder does.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace isoextract::files {

class TemporaryName {
 public:
  // make_file() and name_file() lock the file for as long as the name exists, so that other processes see that it has
  // an owner. Once per process and folder, they first remove files left by ended processes of this user and machine. On
  // file systems without locks they neither lock nor remove files. They return nothing, with errno set, on failure.
  struct File;
  // Creates a named file in `folder`, open for reading and writing.
  [[nodiscard]] static std::optional<File> make_file(const std::filesystem::path& folder);
  // Names an open file that has no name (O_TMPFILE).
  [[nodiscard]] static std::optional<TemporaryName> name_file(const std::filesystem::path& folder, int fd);

  // Gives the file `path` a second name. Returns nothing, with errno set, on failure.
  [[nodiscard]] static std::optional<TemporaryName> add_second_name(const std::filesystem::path& folder,
                                                                    const std::filesystem::path& path);

  TemporaryName() = default;
  TemporaryName(TemporaryName&& other) noexcept;
  TemporaryName& operator=(TemporaryName&& other) noexcept;
  ~TemporaryName();  // removes the file of that name

  [[nodiscard]] bool empty() const { return name_ == nullptr; }
  [[nodiscard]] const char* c_str() const { return name_->c_str(); }
  // Leaves the file under this name.
  void keep();
  // Renames the file to `target`. Returns false, with errno set, on failure.
  [[nodiscard]] bool rename_to(const std::filesystem::path& target);

  // Removes the temporary files of this process (256 at most) and prevents new ones. For signal handlers:
  // async-signal-safe. Waits at most 1 s for files that other threads are making. A thread blocks all signals while it
  // makes a file, so another thread must be able to receive them.
  static void remove_all() noexcept;

 private:
  template <class Make>
  static std::optional<TemporaryName> make(const std::filesystem::path& folder, Make make);
  // Releases the name. Returns nothing if there was none or if a handler is removing the file.
  std::unique_ptr<const std::string> take() noexcept;

  std::unique_ptr<const std::string> name_;
  int slot_ = -1;  // index in the table for signal handlers
  int lock_ = -1;
};

struct TemporaryName::File {
  TemporaryName name;
  int fd = -1;  // the caller closes it
};

}  // namespace isoextract::files

// Prints the program's messages to stderr, one line each; only hints may have several lines. Text from files and paths
// is made printable (base/printable.hpp). stdout carries data only. Of several ranks, only rank 0 prints.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"

namespace spdlog {
class logger;
}

namespace isoextract::cli {

enum class Verbosity { quiet, normal, verbose };

// The messages that a command prints.
struct MessageChoice {
  Verbosity verbosity = Verbosity::normal;
  std::vector<NoteId> hidden = {};  // notes that are not printed
};

class Messages {
 public:
  explicit Messages(MessageChoice choice);

  void error(const Error& error) const;       // "isoextract: error: ..." and "  hint: ..."; even when quiet
  void note(const Note& note) const;          // "isoextract: note[ID]: ..."; not when quiet or hidden
  void summary(std::string_view text) const;  // a line about a written file or a run; not when quiet
  // Prints lines for --explain; not when quiet. The caller checks whether --explain is given.
  void explanation(std::string_view text) const;
  void detail(std::string_view text) const;  // only when verbose

  [[nodiscard]] Verbosity verbosity() const { return choice_.verbosity; }

 private:
  // Returns the word, in color if the terminal shows colors.
  [[nodiscard]] std::string colored(std::string_view word, std::string_view color) const;

  MessageChoice choice_;
  bool colors_;
  std::shared_ptr<spdlog::logger> log_;
};

// Converts the std::exception that is being handled to an Error. Call only in the catch block of the exception.
[[nodiscard]] Error error_of_exception();

// Writes all of `text` to stdout. Fails with ErrorCode::output, for example on a closed pipe or a full disk.
[[nodiscard]] Result<void> print_to_stdout(std::string_view text);

}  // namespace isoextract::cli

// Prints the program's messages to stderr, one line each; only hints can have a list. Text from files and paths is made
// printable (base/printable.hpp). stdout carries data only.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace spdlog {
class logger;
}

namespace isoextract::cli {

enum class Verbosity { quiet, normal, verbose };

class Messages {
 public:
  explicit Messages(Verbosity verbosity);

  void error(const Error& error) const;           // "isoextract: error: ..." and "  hint: ..."; never silent
  void note(std::string_view text) const;         // "isoextract: note: ..."; not when quiet
  void summary(std::string_view text) const;      // results; not when quiet
  void explanation(std::string_view text) const;  // only with --explain; not when quiet
  void detail(std::string_view text) const;       // only when verbose

  [[nodiscard]] Verbosity verbosity() const { return verbosity_; }

 private:
  // The word in a color where the terminal shows colors.
  [[nodiscard]] std::string colored(std::string_view word, std::string_view color) const;

  Verbosity verbosity_;
  bool colors_;
  std::shared_ptr<spdlog::logger> log_;
};

// Returns the exception being handled as an error. Call in a catch block.
[[nodiscard]] Error error_of_exception();

// Writes all of `text` to stdout. Fails with ErrorCode::output, for example on a closed pipe or a full disk.
[[nodiscard]] Result<void> print_to_stdout(std::string_view text);

}  // namespace isoextract::cli

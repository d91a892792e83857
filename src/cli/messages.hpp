// What the program says of its work: on stderr, one line each, hints apart, which can have a list. Whatever came into
// the text from a file or a path, it is printable (base/printable.hpp). stdout carries data only.
#pragma once

#include <memory>
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
  void summary(std::string_view text) const;      // what was done; not when quiet
  void explanation(std::string_view text) const;  // for --explain, which asks for it; not when quiet
  void detail(std::string_view text) const;       // only when verbose

  [[nodiscard]] Verbosity verbosity() const { return verbosity_; }

 private:
  Verbosity verbosity_;
  std::shared_ptr<spdlog::logger> log_;
};

// The exception that is being handled, as an error: for use in a catch block.
[[nodiscard]] Error error_of_exception();

// Writes `text` to stdout as a whole. Fails with ErrorCode::output, for example on a closed pipe or a full disk.
[[nodiscard]] Result<void> print_to_stdout(std::string_view text);

}  // namespace isoextract::cli

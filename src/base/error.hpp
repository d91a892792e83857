// Errors are values: every function that can fail below `cli` returns Result<T>; nothing there prints, throws across
// a room's border or exits. `cli` turns an Error into a message on stderr and the exit code of its kind.
#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace isoextract {

// The numeric values are the program's exit codes.
enum class ErrorKind {
  usage = 1,         // the options or their combination make no sense
  input = 2,         // the input cannot be read, or does not hold what was asked for
  unavailable = 3,   // a feature or device that was asked for is not there
  output = 4,        // the result cannot be written
  verification = 6,  // what was to be verified does not hold
};

struct Error {
  ErrorKind kind;
  std::string message;  // names the file, what was expected and what was found; no trailing full stop or newline
  std::string hint;     // the option or step that helps; may be empty
};

template <class T>
using Result = tl::expected<T, Error>;

// return fail(ErrorKind::input, "a.nrrd: expected ..., found ...", "use --grid NAME");
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorKind kind, std::string message, std::string hint = {}) {
  return tl::unexpected<Error>(Error{kind, std::move(message), std::move(hint)});
}

}  // namespace isoextract

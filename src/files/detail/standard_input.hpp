// Standard input as a file: a regular file at offset 0 is opened again; other input is read once and kept in memory
// that has a descriptor. So standard input can be mapped, read in any order and read again.
#pragma once

#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"

namespace isoextract::files::detail {

class BufferedInput {
 public:
  // Opens a regular file at offset 0 again; else reads the rest of `descriptor` and reserves the bytes in the context's
  // memory as they arrive, for the lifetime of this object. `descriptor` stays open. Fails with ErrorCode::usage for a
  // terminal, with ErrorCode::input if reading fails, and as Context::reserve() and check() do.
  [[nodiscard]] static Result<BufferedInput> take(int descriptor, const Context& context);

  BufferedInput(BufferedInput&& other) noexcept;
  BufferedInput& operator=(BufferedInput&& other) = delete;
  ~BufferedInput();

  // Returns a new descriptor at byte 0 with its own file offset, which the caller closes; -1 with errno set on failure.
  [[nodiscard]] int open() const;
  [[nodiscard]] int descriptor() const { return descriptor_; }  // owned by this object

 private:
  BufferedInput(int descriptor, std::vector<Reservation> memory);

  int descriptor_ = -1;
  std::vector<Reservation> memory_;
};

// Returns the descriptor of the kept standard input, for a path that other processes can open; do not seek or close it.
// Fails as open_standard_input() does.
[[nodiscard]] Result<int> kept_standard_input(const Context& context);

// Returns a new descriptor of this process's standard input, as BufferedInput::open() does. The first call reads the
// input with its context, and keeps the input or the failure until the process ends. Safe to call from several threads.
[[nodiscard]] Result<int> open_standard_input(const Context& context);

}  // namespace isoextract::files::detail

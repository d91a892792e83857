// Standard input as a file: opened where it is one, else read once and kept in memory that has a descriptor, so that
// whoever reads files, maps them or jumps in them can read it as often as is needed.
#pragma once

#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"

namespace isoextract::files::detail {

class KeptInput {
 public:
  // What is left to read of `descriptor`, which stays open. Bytes that are kept are reserved in the context's memory as
  // they come, and for as long as this lives. Fails with ErrorCode::usage for a terminal.
  [[nodiscard]] static Result<KeptInput> take(int descriptor, const Context& context);

  KeptInput(KeptInput&& other) noexcept;
  KeptInput& operator=(KeptInput&& other) = delete;
  ~KeptInput();

  // A new descriptor that starts at the first byte and shares its place with no other; the caller closes it. -1 with
  // errno set where that fails.
  [[nodiscard]] int open() const;

 private:
  KeptInput(int descriptor, std::vector<Reservation> memory);

  int descriptor_ = -1;
  std::vector<Reservation> memory_;
};

// The same for this process's standard input, which is taken at the first call, in that call's context, and kept until
// the process ends. May be called by several threads.
[[nodiscard]] Result<int> open_standard_input(const Context& context);

}  // namespace isoextract::files::detail

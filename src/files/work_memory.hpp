// Memory for a large array: reserved memory, or a temporary file if the memory limit does not hold the array.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"
#include "files/scratch_file.hpp"

namespace isoextract::files {

// When an array goes to a file.
struct FileUse {
  bool prefers_file = false;      // before it tries reserved memory; else after that failed
  std::uint64_t least_bytes = 0;  // no smaller array goes to a file
  std::string_view kind_of_data;  // for a hint: "samples"
  std::uint64_t all_bytes = 0;    // for the hint: the disk space of this array and of others with it, if more
};

// Movable, not copyable.
class WorkMemory {
 public:
  // Makes `bytes` bytes: uninitialized in memory, zeros in a file. Fails as Context::reserve(), with what is needed for
  // a temporary file as a hint. Throws std::bad_alloc.
  [[nodiscard]] static Result<WorkMemory> make(std::uint64_t bytes, const FileUse& use, const Context& context,
                                               const std::string& what);
  // Makes a file, whatever `use` prefers. Fails with `refusal`, the error of memory, and appends why there is no file
  // and what one needs.
  [[nodiscard]] static Result<WorkMemory> make_in_file(std::uint64_t bytes, const FileUse& use, Error refusal);

  // Returns all bytes, at least at the start of a cache line.
  [[nodiscard]] std::span<std::byte> bytes();
  [[nodiscard]] bool is_in_file() const { return std::holds_alternative<ScratchFile>(place_); }
  // If the bytes are in a file, gives the memory of a part back to the system. The part stays readable and writable.
  void leave(std::span<const std::byte> part) const;
  // Returns whether the disk lost some bytes (ScratchFile::lost()).
  [[nodiscard]] bool lost() const;
  // Makes the bytes of a file read-only.
  void protect();

 private:
  // Returns `refusal` with the reason why there is no file, and what one needs.
  [[nodiscard]] static tl::unexpected<Error> refuse(std::uint64_t bytes, const FileUse& use, Error refusal,
                                                    const std::string& reason);

  using Place = std::variant<ReservedBuffer<std::byte>, ScratchFile>;
  explicit WorkMemory(Place place) : place_(std::move(place)) {}

  Place place_;
};

}  // namespace isoextract::files

// Memory in which a reader puts the samples of a dense volume: reserved memory, or a temporary file if the memory limit
// does not hold the samples.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "field/samples.hpp"
#include "files/work_memory.hpp"

namespace isoextract::volume_io {

// Volumes from this size on may go to a temporary file. Smaller ones fit wherever the program itself does.
inline constexpr std::uint64_t kLeastInFile = std::uint64_t{64} << 20U;  // bytes

// Returns whether samples of that size should go to a temporary file if possible: kLeastInFile, and more than half of
// the memory limit. The other half is for the work on them, so a larger limit never makes a conversion fail.
[[nodiscard]] bool prefers_file(std::uint64_t bytes, const Context& context);

// Returns the longest run of layers, each of `layer_bytes`, that a reader may decode at a time into memory besides a
// temporary file: at least 1, at most `layers`. Uses at most half of the memory that is left. Prefers multiples of
// 64, or of smaller powers of two: chunks of files often have such depths, and a chunk in two runs is decoded twice.
[[nodiscard]] int layers_at_once(std::uint64_t layer_bytes, int layers, const Context& context);

class SampleStore {
 public:
  // Makes a store for samples of that type and size. For messages, `source` names the input, and `kind` is empty or
  // tells what the samples are: "lengths of ". `beside` is the memory of other arrays that the caller needs at the same
  // time. Fails as Context::reserve(), with what is needed for a temporary file as a hint. May throw std::bad_alloc.
  [[nodiscard]] static Result<SampleStore> make(const std::string& source, const glm::ivec3& dims,
                                                field::SampleType type, const Context& context,
                                                const std::string& kind = {}, std::uint64_t beside = 0);
  // Makes a store in a temporary file. Fails with `refusal`, the error of memory, and the hint above; also if the
  // samples have less than kLeastInFile bytes.
  [[nodiscard]] static Result<SampleStore> make_in_file(const glm::ivec3& dims, field::SampleType type, Error refusal);

  [[nodiscard]] std::span<std::byte> bytes() { return memory_.bytes(); }
  [[nodiscard]] bool is_in_file() const { return memory_.is_in_file(); }
  // Gives the memory of a part that was filled back to the system. The part stays readable and writable.
  void leave(std::span<const std::byte> part) const { memory_.leave(part); }

  // Returns the samples, which own the memory. Adds a note about a temporary file.
  [[nodiscard]] field::DenseSamples finish(Notes& notes) &&;

 private:
  SampleStore(const glm::ivec3& dims, field::SampleType type, files::WorkMemory memory)
      : dims_(dims), type_(type), memory_(std::move(memory)) {}

  glm::ivec3 dims_;
  field::SampleType type_;
  files::WorkMemory memory_;
};

}  // namespace isoextract::volume_io

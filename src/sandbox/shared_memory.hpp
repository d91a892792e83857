// Memory that this program and a child process share. This side makes it, and decides how large it is: its size can
// never change, so that no access to it fails.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "sandbox/descriptor.hpp"

namespace isoextract::sandbox {

// Memory without a name in any file system: it is gone with the last process that has it.
class SharedMemory {
 public:
  // Zeros. Nothing where the system gives none.
  [[nodiscard]] static std::optional<SharedMemory> create(std::uint64_t bytes);

  [[nodiscard]] int descriptor() const { return descriptor_.get(); }
  [[nodiscard]] std::uint64_t size() const { return bytes_; }

 private:
  SharedMemory(Descriptor descriptor, std::uint64_t bytes) : descriptor_(std::move(descriptor)), bytes_(bytes) {}

  Descriptor descriptor_;
  std::uint64_t bytes_ = 0;
};

// Shared memory in the address space of a process.
class Mapping {
 public:
  enum class Access { read, write };
  // Empty where the system refuses.
  Mapping(int descriptor, std::uint64_t bytes, Access access);
  Mapping(Mapping&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  Mapping& operator=(Mapping&& other) = delete;
  ~Mapping();

  [[nodiscard]] std::span<std::byte> bytes() const { return bytes_; }

 private:
  std::span<std::byte> bytes_;
};

}  // namespace isoextract::sandbox

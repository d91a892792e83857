// Memory shared by this program and a child process. This program creates it and fixes its size, so the child cannot
// make an access fail by shrinking it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "sandbox/descriptor.hpp"

namespace isoextract::sandbox {

// Has no name in any file system; the system frees it when its last descriptor and mapping are closed.
class SharedMemory {
 public:
  // Returns zero-filled memory; nothing if the system provides none. Does not reserve it in a memory budget.
  [[nodiscard]] static std::optional<SharedMemory> create(std::uint64_t bytes);

  [[nodiscard]] int descriptor() const { return descriptor_.get(); }
  [[nodiscard]] std::uint64_t size() const { return bytes_; }

 private:
  SharedMemory(Descriptor descriptor, std::uint64_t bytes) : descriptor_(std::move(descriptor)), bytes_(bytes) {}

  Descriptor descriptor_;
  std::uint64_t bytes_ = 0;
};

// Maps shared memory into this process.
class Mapping {
 public:
  enum class Access { read, write };
  // bytes() is empty if `bytes` is 0 or the system refuses the mapping.
  Mapping(int descriptor, std::uint64_t bytes, Access access);
  Mapping(Mapping&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  Mapping& operator=(Mapping&& other) = delete;
  ~Mapping();

  [[nodiscard]] std::span<std::byte> bytes() const { return bytes_; }

 private:
  std::span<std::byte> bytes_;
};

}  // namespace isoextract::sandbox

// A fixed-size heap array with uninitialized elements: large outputs are written once, by the threads that compute
// them, and never zeroed first. Owns its memory. Movable (the moved-from buffer is empty), not copyable.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

namespace isoextract {

namespace detail {
// Allocates count * size bytes, aligned at least to a cache line. Returns null for 0 bytes. Throws std::bad_alloc.
// Blocks of 4 MiB and more use huge pages where the system allows them. free_block() keeps up to 16 of these large
// blocks for later calls, with at most 512 MiB or 1/16 of the machine's memory, whichever is less.
[[nodiscard]] void* allocate_block(std::size_t count, std::size_t size);
void free_block(void* block);
// Frees the oldest kept blocks until the rest hold at most `bytes` bytes.
void trim_kept_blocks(std::uint64_t bytes);
}  // namespace detail

template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  using value_type = T;

  Buffer() = default;

  // Throws std::bad_alloc. If the size comes from a file or an option, call Context::reserve() first.
  explicit Buffer(std::size_t size) : data_(static_cast<T*>(detail::allocate_block(size, sizeof(T)))), size_(size) {}

  Buffer(Buffer&& other) noexcept : data_(std::move(other.data_)), size_(std::exchange(other.size_, 0)) {}
  Buffer& operator=(Buffer&& other) noexcept {
    data_ = std::move(other.data_);
    size_ = std::exchange(other.size_, 0);
    return *this;
  }
  ~Buffer() = default;

  [[nodiscard]] T* data() { return data_.get(); }
  [[nodiscard]] const T* data() const { return data_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t size_bytes() const { return size_ * sizeof(T); }

  [[nodiscard]] T& operator[](std::size_t i) { return data_.get()[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return data_.get()[i]; }

  [[nodiscard]] T* begin() { return data(); }
  [[nodiscard]] T* end() { return data() + size_; }
  [[nodiscard]] const T* begin() const { return data(); }
  [[nodiscard]] const T* end() const { return data() + size_; }

  [[nodiscard]] std::span<T> span() { return {data(), size_}; }
  [[nodiscard]] std::span<const T> span() const { return {data(), size_}; }

 private:
  struct Free {
    void operator()(T* p) const { detail::free_block(p); }
  };

  std::unique_ptr<T, Free> data_;
  std::size_t size_ = 0;
};

}  // namespace isoextract

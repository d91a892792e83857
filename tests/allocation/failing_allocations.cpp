#include "allocation/failing_allocations.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <new>

#include <dlfcn.h>
#include <execinfo.h>
#include <malloc.h>
#include <sys/mman.h>

namespace {

constexpr std::size_t kOrdinary = alignof(std::max_align_t);

std::atomic<std::uint64_t> asked_for{0};
std::atomic<std::uint64_t> fails_at{0};  // 0: no allocation fails
std::atomic<bool> reached{false};
std::atomic<std::int64_t> live{0};

// Debian's TinyGLTF ends the process if one of its own allocations fails: its JSON library (nlohmann 3.11) asserts that
// an object exists, and its destructor allocates memory.
bool for_tinygltf() {
  std::array<void*, 64> frames{};
  const int count = ::backtrace(frames.data(), static_cast<int>(frames.size()));
  return std::any_of(frames.begin(), frames.begin() + count, [](const void* frame) {
    Dl_info info{};
    return ::dladdr(frame, &info) != 0 && std::strstr(info.dli_fname, "libtinygltf") != nullptr;
  });
}

bool fails_now() {
  const std::uint64_t at = fails_at.load(std::memory_order_relaxed);
  if (at == 0 || asked_for.fetch_add(1, std::memory_order_relaxed) + 1 != at) return false;
  reached = true;
  return !for_tinygltf();
}

void* take(std::size_t size, std::size_t alignment) noexcept {
  if (fails_now()) return nullptr;
  const std::size_t bytes = size == 0 ? 1 : size;
  void* const block = alignment <= kOrdinary ? std::malloc(bytes) : ::memalign(alignment, bytes);
  if (block != nullptr) live.fetch_add(1, std::memory_order_relaxed);
  return block;
}

void* take_or_throw(std::size_t size, std::size_t alignment) {
  void* const block = take(size, alignment);
  if (block == nullptr) throw std::bad_alloc();
  return block;
}

void give_back(void* block) noexcept {
  if (block == nullptr) return;
  live.fetch_sub(1, std::memory_order_relaxed);
  std::free(block);
}

std::size_t number_of(std::align_val_t alignment) { return static_cast<std::size_t>(alignment); }

}  // namespace

namespace isoextract::test {

void fail_allocation(std::uint64_t number) {
  static_cast<void>(for_tinygltf());  // the first backtrace allocates memory
  asked_for = 0;
  reached = false;
  fails_at = number;
}

bool allocation_reached() {
  fails_at = 0;
  return reached;
}

std::int64_t live_allocations() { return live; }

}  // namespace isoextract::test

// NOLINTBEGIN(misc-new-delete-overloads)
void* operator new(std::size_t size) { return take_or_throw(size, kOrdinary); }
void* operator new[](std::size_t size) { return take_or_throw(size, kOrdinary); }
void* operator new(std::size_t size, std::align_val_t a) { return take_or_throw(size, number_of(a)); }
void* operator new[](std::size_t size, std::align_val_t a) { return take_or_throw(size, number_of(a)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return take(size, kOrdinary); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return take(size, kOrdinary); }
void* operator new(std::size_t size, std::align_val_t a, const std::nothrow_t&) noexcept {
  return take(size, number_of(a));
}
void* operator new[](std::size_t size, std::align_val_t a, const std::nothrow_t&) noexcept {
  return take(size, number_of(a));
}
void operator delete(void* block) noexcept { give_back(block); }
void operator delete[](void* block) noexcept { give_back(block); }
void operator delete(void* block, std::size_t) noexcept { give_back(block); }
void operator delete[](void* block, std::size_t) noexcept { give_back(block); }
void operator delete(void* block, std::align_val_t) noexcept { give_back(block); }
void operator delete[](void* block, std::align_val_t) noexcept { give_back(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { give_back(block); }
void operator delete[](void* block, std::size_t, std::align_val_t) noexcept { give_back(block); }
void operator delete(void* block, const std::nothrow_t&) noexcept { give_back(block); }
void operator delete[](void* block, const std::nothrow_t&) noexcept { give_back(block); }
void operator delete(void* block, std::align_val_t, const std::nothrow_t&) noexcept { give_back(block); }
void operator delete[](void* block, std::align_val_t, const std::nothrow_t&) noexcept { give_back(block); }
// NOLINTEND(misc-new-delete-overloads)

// The linker replaces calls of aligned_alloc and mmap in the code of the program by these functions.
extern "C" {
void* __real_aligned_alloc(std::size_t alignment, std::size_t size);
void* __real_mmap(void* address, std::size_t length, int protection, int flags, int file, off_t offset);

void* __wrap_aligned_alloc(std::size_t alignment, std::size_t size) {
  return fails_now() ? nullptr : __real_aligned_alloc(alignment, size);
}

void* __wrap_mmap(void* address, std::size_t length, int protection, int flags, int file, off_t offset) {
  if (!fails_now()) return __real_mmap(address, length, protection, flags, file, offset);
  errno = ENOMEM;
  return MAP_FAILED;
}
}

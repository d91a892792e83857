// Memory pages of mapped files and of the allocator.
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace isoextract {

// Gives the whole pages within [begin, begin + bytes) back to the system, which reads them from the file again at the
// next access. Only for read-only or shared file mappings (DenseSamples::file_backed): other memory would lose its
// contents. Safe while other threads use the same pages.
void release_pages(const void* begin, std::size_t bytes);

// Asks the system to read pages of a mapped file shortly before threads read them, each block at most once. Large
// requests are faster than the short ones that the system makes where threads reach missing pages. For a pass in which
// every thread moves towards higher addresses.
class PageRequests {
 public:
  static constexpr std::size_t kBlock = std::size_t{1} << 19U;  // bytes of one request
  static constexpr std::size_t kAhead = std::size_t{8} << 20U;  // bytes that are requested before they are read

  PageRequests() = default;  // requests nothing
  // Prepares requests for [begin, begin + bytes), which must be part of a mapped file.
  PageRequests(const void* begin, std::size_t bytes);

  // Requests the pages of [place, place + kAhead) that are part of the range. Does not wait for them. Call it before
  // reading there, and again before reading more. Safe to call from several threads.
  void come_to(const void* place);

 private:
  void request(std::size_t block) const;

  const std::byte* begin_ = nullptr;
  std::size_t bytes_ = 0;
  std::vector<std::atomic<bool>> is_requested_;  // by block
};

// Gives the allocator's free pages, and the blocks that Buffer keeps for reuse, back to the system. Worthwhile after a
// stage that needs much more memory than later stages: getting the pages again takes longer than filling them.
void release_free_memory();

// Makes the allocator give each block of 1 MiB or more back to the system as soon as it is freed, from now on. By
// default glibc keeps ever larger freed blocks for each thread, so the memory of many short-lived meshes adds up.
void return_large_blocks();

}  // namespace isoextract

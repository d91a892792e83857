// Memory pages of mapped files and of the allocator.
#pragma once

#include <cstddef>

namespace isoextract {

// Gives the whole pages within [begin, begin + bytes) back to the system, which reads them from the file again at the
// next access. Only for read-only or shared file mappings (DenseSamples::file_backed): other memory would lose its
// contents. Safe while other threads use the same pages.
void release_pages(const void* begin, std::size_t bytes);

// Gives the allocator's free pages, and the blocks that Buffer keeps for reuse, back to the system. Worthwhile after a
// stage that needs much more memory than later stages: getting the pages again takes longer than filling them.
void release_free_memory();

// Makes the allocator give each block of 1 MiB or more back to the system as soon as it is freed, from now on. By
// default glibc keeps ever larger freed blocks for each thread, so the memory of many short-lived meshes adds up.
void return_large_blocks();

}  // namespace isoextract

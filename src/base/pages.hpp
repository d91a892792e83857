// Memory pages of mapped files.
#pragma once

#include <cstddef>

namespace isoextract {

// Gives the whole pages within [begin, begin + bytes) back to the system, which reads them from the file again at the
// next access. Only for read-only file mappings (DenseSamples::file_backed): other memory would lose its contents. Safe
// while other threads read the same pages.
void release_pages(const void* begin, std::size_t bytes);

}  // namespace isoextract

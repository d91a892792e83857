// The pages of mapped files.
#pragma once

#include <cstddef>

namespace isoextract {

// Gives the whole pages within [begin, begin + bytes) back to the system; what they hold comes again from their file
// when it is next looked at. Only for read-only mappings of files, which DenseSamples::file_backed tells: other memory
// would lose what it holds. Safe while other threads read the same pages.
void give_back_pages(const void* begin, std::size_t bytes);

}  // namespace isoextract

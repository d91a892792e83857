#include "field/samples.hpp"

#include "base/pages.hpp"

namespace isoextract::field {

void DenseSamples::leave(std::size_t begin, std::size_t end) const {
  if (!releases_pages()) return;
  const std::size_t size = sample_size(type);
  release_pages(static_cast<const std::byte*>(data) + begin * size, (end - begin) * size);
}

}  // namespace isoextract::field

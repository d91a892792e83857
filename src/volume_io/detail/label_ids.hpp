// Replaces 64-bit ids of labels by 32-bit indices into a table of the ids, as double is exact only up to 2^53.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"
#include "field/scalar_field.hpp"
#include "volume_io/detail/dense_format.hpp"

namespace isoextract::volume_io {

struct IndexedIds {
  std::shared_ptr<const ReservedBuffer<std::uint32_t>> samples;
  field::LabelIdTable ids;
};

// Returns, for each 64-bit integer in `stored` (native byte order), its index in a table of 0 and all ids that occur.
// Takes four bytes for each sample, reserved in `context`, and two passes. The result does not depend on the number of
// threads. Fails with ErrorCode::input for an id beyond 2^63 - 1; the message has its sample index by `dims`.
// Fails with ErrorCode::out_of_memory, and as Context::check() does. `name` starts the messages.
[[nodiscard]] Result<IndexedIds> index_ids(std::span<const std::byte> stored, Integer64 type, const glm::ivec3& dims,
                                           const std::string& name, const Context& context);

}  // namespace isoextract::volume_io

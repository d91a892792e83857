// Replaces 64-bit ids of labels by 32-bit indices into a table of the ids, as double is exact only up to 2^53.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "field/scalar_field.hpp"
#include "volume_io/detail/dense_format.hpp"

namespace isoextract::volume_io {

struct IndexedIds {
  field::DenseSamples samples;
  field::LabelIdTable ids;
};

// Returns, for each 64-bit integer in `wide`, whatever its sample type, its index in a table of 0 and all ids that
// occur. Takes four bytes for each sample in a SampleStore, and two passes, which release pages of a large file.
// The result does not depend on the number of threads. Fails with ErrorCode::input if samples were lost, and for an id
// beyond 2^63 - 1; the message has its sample index. Fails with ErrorCode::out_of_memory, and as Context::check() does.
// `name` starts the messages. `notes` gets a note about a temporary file.
[[nodiscard]] Result<IndexedIds> index_ids(const field::DenseSamples& wide, Integer64 type, const std::string& name,
                                           const Context& context, Notes& notes);

}  // namespace isoextract::volume_io

// Samples that are mapped a few layers at a time, because the address space does not hold their whole file.
#pragma once

#include <optional>

#include "base/note.hpp"
#include "field/samples.hpp"
#include "volume_io/detail/sample_source.hpp"

namespace isoextract::volume_io {

// Returns samples that have DenseSamples::layers, and adds a note that tells why. Returns nothing if the system has not
// limited the address space (RLIMIT_AS), if the layout does not fit (map_samples()), or if not even one layer can be
// mapped. Reports all bytes as "reading" at once.
[[nodiscard]] std::optional<field::DenseSamples> map_layers(const SampleSource& source, field::SampleType type,
                                                            const glm::ivec3& dims, const Context& context,
                                                            Notes& notes);

// Returns whether mapping the whole source would leave less than half of the address space that the system has left.
[[nodiscard]] bool fills_address_space(const SampleSource& source);

}  // namespace isoextract::volume_io

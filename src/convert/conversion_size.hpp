// How large a conversion is before it is done: estimates for `info` and for dry runs.
#pragma once

#include <cstdint>

#include "base/error.hpp"
#include "base/memory_budget.hpp"
#include "convert/conversion_job.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

// What a conversion at an iso value has to do with; estimated but for the samples.
struct ConversionSize {
  std::uint64_t samples = 0;  // that are stored
  std::uint64_t sample_bytes = 0;
  std::uint64_t lookup_bytes = 0;  // to find sparse blocks by their place
  std::uint64_t places = 0;        // of sparse samples that the surface passes
  std::uint64_t vertices = 0;
};

// The program itself, on a few threads and without the libraries that plug-ins load.
inline constexpr std::uint64_t kProgramBytes = std::uint64_t{14} << 20U;
// What the conversion of a field touches of it besides: extraction, writers.
inline constexpr std::uint64_t kConversionBytes = std::uint64_t{3} << 20U;

// Only of the samples.
[[nodiscard]] ConversionSize size_of_samples(const field::ScalarField& field);
// And of its surface.
[[nodiscard]] ConversionSize size_of(const field::ScalarField& field, double iso);

// The peak of memory: the program itself, the samples, two bits of marks for each, what finds its way among sparse
// blocks, and the mesh with normals. Within a tenth of what large conversions take, for blocks far apart a fifth.
[[nodiscard]] std::uint64_t estimated_bytes(const ConversionSize& size);
// A closed surface has about twice as many as vertices.
[[nodiscard]] std::uint64_t estimated_triangles(const ConversionSize& size);

// estimated_bytes() of a job, at its iso value that needs most. Reads the field, and fails as that does.
[[nodiscard]] Result<std::uint64_t> estimated_memory(const ConversionJob& job, const MemoryBudget& memory);

}  // namespace isoextract::convert

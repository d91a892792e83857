// Estimates of a conversion's size before it runs, for `info` and dry runs.
#pragma once

#include <cstdint>
#include <optional>

#include "base/error.hpp"
#include "base/memory_budget.hpp"
#include "convert/conversion_job.hpp"
#include "extract/extractor.hpp"
#include "extract/label_map_size.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

// Sizes of a conversion at one iso value. `places` and the numbers of vertices are estimates.
struct ConversionSize {
  std::uint64_t samples = 0;  // stored samples
  std::uint64_t sample_bytes = 0;
  std::uint64_t resident_bytes = 0;  // sample_bytes; for a large mapped file, the bytes of the slices in work only
  std::uint64_t mark_bytes = 0;      // of the inside bits, and of the tables of rows or blocks
  std::uint64_t slabs = 0;           // parts of the mesh that go to the file one by one; 0 without any
  std::uint64_t lookup_bytes = 0;    // of the lookup table that finds sparse blocks
  std::uint64_t places = 0;          // block positions of a sparse field that the surface passes through
  std::uint64_t vertices = 0;        // with those of the cap
  std::uint64_t cap_vertices = 0;    // of dense samples
  std::optional<bool> has_nan = {};  // whether samples of the region are NaN; nullopt: unknown, as of sparse samples
};

// Memory of the program itself, on a few threads and without the libraries that plug-ins load.
inline constexpr std::uint64_t kProgramBytes = std::uint64_t{15} << 20U;
// Memory of a conversion besides the field and the mesh: extraction and writers.
inline constexpr std::uint64_t kConversionBytes = std::uint64_t{7} << 19U;

// Returns the sizes of the samples alone.
[[nodiscard]] ConversionSize size_of_samples(const field::ScalarField& field);
// Returns the sizes of the samples and of the surface. Takes the region of dense samples into account, but not that of
// sparse ones.
[[nodiscard]] ConversionSize size_of(const field::ScalarField& field, const extract::ExtractOptions& options);

// Returns the estimated peak memory: kProgramBytes, kConversionBytes, the samples and their marks, the lookup tables of
// sparse blocks, the lists of a cap, and the mesh with normals. Within 10 % for large conversions, 20 % for sparse
// blocks far apart.
[[nodiscard]] std::uint64_t estimated_bytes(const ConversionSize& size);
// Returns the same for a mesh that goes to its file part by part (extract::ExtractOptions::sink), with or without
// figures (mesh/partwise_measures.hpp). A part is the mesh of one slab, taken to be 1.25 times the mean; the format
// decides how many parts are in memory at a time. Underestimates a surface that lies in few slabs.
[[nodiscard]] std::uint64_t estimated_bytes_by_parts(const ConversionSize& size, const MeshFileOptions& file,
                                                     Normals normals, bool has_figures = false);
// Returns the estimated memory of making the surfaces of labels, besides what is kept of finding them. Up to
// `most_held` bytes of surfaces wait for the others of their file (mesh_io::most_held_bytes()). Editing or packing the
// largest surface takes `edit_bytes`.
[[nodiscard]] std::uint64_t label_making_bytes(const extract::LabelMapSize& size, std::uint64_t most_held,
                                               std::uint64_t edit_bytes);
// Returns the estimated peak memory of the surfaces of labels: the largest of finding their voxels, the rest of
// finding them, and making the surfaces. `making_bytes` is label_making_bytes(), or what simplifying takes.
[[nodiscard]] std::uint64_t estimated_label_bytes(const field::ScalarField& field, const extract::LabelMapSize& size,
                                                  std::uint64_t making_bytes);
// Returns twice the number of vertices, as a closed surface has.
[[nodiscard]] std::uint64_t estimated_triangles(const ConversionSize& size);

// The use of a mesh besides its file.
enum class MeshUse {
  none,
  figures,  // ConversionOptions::mesh_facts
  whole     // the mesh in memory, such as for an animation
};

// Returns the estimated peak memory of a job, for the grid and iso value that need most. It is the sum of
// estimated_bytes(), vertex attributes, and the largest of simplification, packing, hollowing and error measurement. A
// mesh that goes to its file part by part counts as estimated_bytes_by_parts(). Surfaces that wait for the others of
// their file count, too. If making the field (from particles, by a blur) or writing a field file needs more, returns
// that. For mesh files and for jobs that write particles, returns the peak of reading, plus the edits of the meshes.
// Reads the input, and fails as open_source() and read_particles() do.
[[nodiscard]] Result<std::uint64_t> estimated_memory(const ConversionJob& job, MeshUse use, const MemoryBudget& memory);

}  // namespace isoextract::convert

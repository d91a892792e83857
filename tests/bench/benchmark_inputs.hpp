// The volumes of the benchmark.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "field/scalar_field.hpp"

namespace isoextract::bench {

class VdbGrid;  // an OpenVDB grid; only openvdb_contestants.cpp looks into it

struct BenchmarkInput {
  std::string name;  // as in --fields
  int size = 0;      // samples along an axis; 0 for files, whose dims are their own
  field::ScalarField field;
  double iso = 0;
  std::shared_ptr<const VdbGrid> grid;  // its leaves are the blocks of `field`; null for dense fields
};

enum class Source {
  formula,  // a demo field, of any size
  random,   // a demo field of kRandomSize, whatever sizes are asked for: noise has five triangles a cell
  file,     // of the folder of real volumes
  vdb,      // a VDB tree: a sphere that is as large in proportion to `size` as demo:sphere
};
inline constexpr int kRandomSize = 128;

struct InputDescription {
  std::string_view name;  // as in --fields
  Source source;
  std::string_view origin;  // demo field, or file of the data folder
  double iso;
};

[[nodiscard]] std::span<const InputDescription> benchmark_inputs();
[[nodiscard]] const InputDescription& find_input(std::string_view name);  // throws for an unknown name

// Returns the input in its own type: f32, but for files. Returns nothing if the data folder lacks the file; throws for
// other failures. Files and noise ignore `size`.
[[nodiscard]] std::optional<BenchmarkInput> make_input(const InputDescription& description, int size);

// Returns a copy in another type: f32 of any, 8 and 16-bit integers of f32; dense fields only. Quantizing is linear, so
// that the largest distance of a sample from iso just fits; iso becomes the middle between two integers, and each
// sample stays on its side.
[[nodiscard]] BenchmarkInput with_type(const BenchmarkInput& input, field::SampleType type);

// Writes the samples of a dense input as they are in memory, for programs that read raw files.
void write_raw(const BenchmarkInput& input, const std::filesystem::path& path);

// Returns an input for make_input(): a narrow band around a sphere with iso 0, or the fog in it with iso 0.5.
// In openvdb_contestants.cpp.
[[nodiscard]] BenchmarkInput make_level_set(int size);
[[nodiscard]] BenchmarkInput make_fog(int size);

}  // namespace isoextract::bench

// The timed programs: isoextract's extractor, others that do the same, and plain reading and writing of memory.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bench/benchmark_inputs.hpp"
#include "extract/extractor.hpp"

namespace isoextract::bench {

struct Outcome {
  double milliseconds = 0;
  std::uint64_t triangles = 0;
  std::uint64_t vertices = 0;
  std::uint64_t bytes_read = 0;     // each sample once
  std::uint64_t bytes_written = 0;  // of the mesh that was returned
};

class Contestant {
 public:
  virtual ~Contestant() = default;
  [[nodiscard]] virtual std::string name() const = 0;     // "FlyingEdges3D", "mc"
  [[nodiscard]] virtual std::string program() const = 0;  // and whose that is: "VTK 9.1.0"
  // Extracts once. Only that is on the clock: the output is freed after it has stopped. Throws what goes wrong.
  [[nodiscard]] virtual Outcome run() = 0;
};

using Contestants = std::vector<std::unique_ptr<Contestant>>;

// They keep a reference to `input`.
[[nodiscard]] std::unique_ptr<Contestant> isoextract_contestant(const BenchmarkInput& input, extract::Method method,
                                                                bool smooth_normals);
// Returns contestants for dense samples; none for other inputs.
[[nodiscard]] Contestants vtk_contestants(const BenchmarkInput& input, bool smooth_normals);
// Returns contestants for VDB grids; none for other inputs.
[[nodiscard]] Contestants openvdb_contestants(const BenchmarkInput& input);
// memory_reader() reads the samples of `input` once; memory_writer() writes `output_bytes` once to fresh memory, as an
// extractor does. Together they are the least that an extraction could take.
[[nodiscard]] std::unique_ptr<Contestant> memory_reader(const BenchmarkInput& input);
[[nodiscard]] std::unique_ptr<Contestant> memory_writer(std::uint64_t output_bytes);

// Returns the bytes of all samples; for sparse samples, those of their blocks.
[[nodiscard]] std::uint64_t sample_bytes(const BenchmarkInput& input);

}  // namespace isoextract::bench

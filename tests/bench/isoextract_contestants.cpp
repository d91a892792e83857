#include <stdexcept>

#include "base/stopwatch.hpp"
#include "base/version.hpp"
#include "bench/contestant.hpp"

namespace isoextract::bench {
namespace {

class IsoextractContestant : public Contestant {
 public:
  IsoextractContestant(const BenchmarkInput& input, extract::Method method, bool smooth_normals) : input_(input) {
    options_.method = method;
    options_.iso = input.iso;
    options_.smooth_normals = smooth_normals;
  }

  [[nodiscard]] std::string name() const override { return std::string(word_of(options_.method)); }
  [[nodiscard]] std::string program() const override { return std::string(generator()); }

  Outcome run() override {
    const Stopwatch watch;
    const Result<extract::Extraction> extraction = extractor_->extract(input_.field, options_, Context());
    const double seconds = watch.elapsed().wall_seconds;
    if (!extraction) throw std::runtime_error(extraction.error().message);
    const mesh::Mesh& mesh = extraction->mesh;
    return {1000 * seconds, mesh.triangles.size(), mesh.positions.size(), sample_bytes(input_),
            mesh.positions.size_bytes() + mesh.normals.size_bytes() + mesh.triangles.size_bytes()};
  }

 private:
  const BenchmarkInput& input_;
  extract::ExtractOptions options_;
  std::unique_ptr<extract::Extractor> extractor_ = extract::make_cpu_extractor();
};

}  // namespace

std::unique_ptr<Contestant> isoextract_contestant(const BenchmarkInput& input, extract::Method method,
                                                  bool smooth_normals) {
  return std::make_unique<IsoextractContestant>(input, method, smooth_normals);
}

}  // namespace isoextract::bench

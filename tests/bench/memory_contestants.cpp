#include <algorithm>
#include <cstring>
#include <numeric>
#include <span>
#include <stdexcept>

#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include "base/buffer.hpp"
#include "base/stopwatch.hpp"
#include "bench/contestant.hpp"

namespace isoextract::bench {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kPiece = std::size_t{1} << 20U;  // bytes that a thread takes at a time

// The samples in pieces that are one after the other in memory.
std::vector<Bytes> pieces_of(const field::ScalarField& field) {
  std::vector<Bytes> pieces;
  const std::size_t size = field::sample_size(field.type());
  if (const auto* dense = std::get_if<field::DenseSamples>(&field.samples)) {
    const Bytes all(static_cast<const std::byte*>(dense->data), dense->count() * size);
    for (std::size_t begin = 0; begin < all.size(); begin += kPiece) {
      pieces.push_back(all.subspan(begin, std::min(kPiece, all.size() - begin)));
    }
  } else {
    constexpr std::size_t kBlockSamples =
        field::SparseBlock::kSize * field::SparseBlock::kSize * field::SparseBlock::kSize;
    for (const field::SparseBlock& block : std::get<field::SparseSamples>(field.samples).blocks) {
      pieces.emplace_back(static_cast<const std::byte*>(block.values), kBlockSamples * size);
    }
  }
  return pieces;
}

// Of the words of 8 bytes; what is left over of the last piece is too little to matter.
std::uint64_t sum(Bytes piece) {
  std::uint64_t total = 0;
  for (std::size_t at = 0; at + sizeof(total) <= piece.size(); at += sizeof(total)) {
    std::uint64_t word = 0;
    std::memcpy(&word, piece.data() + at, sizeof(word));
    total += word;
  }
  return total;
}

class MemoryReader : public Contestant {
 public:
  explicit MemoryReader(const BenchmarkInput& input) : pieces_(pieces_of(input.field)), bytes_(sample_bytes(input)) {}

  [[nodiscard]] std::string name() const override { return "read samples once"; }
  [[nodiscard]] std::string program() const override { return "memory"; }

  Outcome run() override {
    const Stopwatch watch;
    const std::uint64_t total = tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, pieces_.size()), std::uint64_t{0},
        [&](const auto& range, std::uint64_t so_far) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) so_far += sum(pieces_[i]);
          return so_far;
        },
        std::plus<>());
    const double seconds = watch.elapsed().wall_seconds;
    // So that the sums are needed, and computed.
    if (const std::uint64_t before = std::exchange(total_, total); before != 0 && before != total) {
      throw std::runtime_error("the samples have changed between two runs");
    }
    return {1000 * seconds, 0, 0, bytes_, 0};
  }

 private:
  std::vector<Bytes> pieces_;
  std::uint64_t bytes_;
  std::uint64_t total_ = 0;
};

class MemoryWriter : public Contestant {
 public:
  explicit MemoryWriter(std::uint64_t bytes) : bytes_(bytes) {}

  [[nodiscard]] std::string name() const override { return "write output once"; }
  [[nodiscard]] std::string program() const override { return "memory"; }

  Outcome run() override {
    const Stopwatch watch;
    Buffer<std::byte> output(bytes_);
    const std::size_t pieces = (bytes_ + kPiece - 1) / kPiece;
    tbb::parallel_for(std::size_t{0}, pieces, [&](std::size_t piece) {
      const std::size_t begin = piece * kPiece;
      std::memset(output.data() + begin, 1, std::min(kPiece, output.size() - begin));
    });
    return {1000 * watch.elapsed().wall_seconds, 0, 0, 0, bytes_};
  }

 private:
  std::uint64_t bytes_;
};

}  // namespace

std::uint64_t sample_bytes(const BenchmarkInput& input) {
  const std::vector<Bytes> pieces = pieces_of(input.field);
  return std::accumulate(pieces.begin(), pieces.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const Bytes& piece) { return sum + piece.size(); });
}

std::unique_ptr<Contestant> memory_reader(const BenchmarkInput& input) { return std::make_unique<MemoryReader>(input); }

std::unique_ptr<Contestant> memory_writer(std::uint64_t output_bytes) {
  return std::make_unique<MemoryWriter>(output_bytes);
}

}  // namespace isoextract::bench

// Parts that the mutators of the fuzz targets share: libFuzzer's own mutation, and choices that follow from its seed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>

// libFuzzer's; the data may grow up to `most` bytes.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace isoextract::fuzz {

class Choices {
 public:
  explicit Choices(unsigned seed) : engine_(seed) {}

  // Returns a number from 0 to count - 1; 0 if count is 0.
  std::size_t below(std::size_t count) {
    return count == 0 ? 0 : std::uniform_int_distribution<std::size_t>(0, count - 1)(engine_);
  }

  // Counts and sizes at which readers go wrong.
  std::uint64_t number() {
    constexpr std::array<std::uint64_t, 16> kNumbers{0,   1,     2,     3,          4,          5,          8,  255,
                                                     256, 65535, 65536, 0x7fffffff, 0x80000000, 0xffffffff, 64, ~0ULL};
    return kNumbers[below(kNumbers.size())];
  }

  // Returns the text after libFuzzer's own mutation.
  std::string mutated(std::string text, std::size_t most) {
    const std::size_t size = text.size();
    text.resize(most);
    text.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(text.data()), size, most));
    return text;
  }

 private:
  std::minstd_rand engine_;
};

// Writes `text` over the input and returns its size; where it is too long, mutates the input as libFuzzer does.
inline std::size_t give_back(const std::string& text, std::uint8_t* data, std::size_t size, std::size_t most) {
  if (text.size() > most || text.empty()) return LLVMFuzzerMutate(data, size, most);
  text.copy(reinterpret_cast<char*>(data), text.size());
  return text.size();
}

}  // namespace isoextract::fuzz

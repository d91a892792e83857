// Mutates BGEO as it was until Houdini 11 by what its header says: counts, and attributes of points that come twice,
// go, or have another size and type. The first byte of an input is the options of the target (fuzz_particles.cpp).
#include <optional>
#include <string>
#include <vector>

#include "fuzz/mutation.hpp"

namespace isoextract::fuzz {
namespace {

constexpr std::size_t kCounts = 6;         // behind the options and the magic
constexpr std::size_t kCountOfPoints = 1;  // among the counts, the version being 0
constexpr std::size_t kCountOfAttributes = 5;
constexpr std::size_t kAttributes = kCounts + 9 * 4;

class Mutation {
 public:
  Mutation(std::string text, unsigned seed, std::size_t most) : text_(std::move(text)), choices_(seed), most_(most) {
    find_attributes();
  }

  std::string run() {
    const std::size_t a = choices_.below(begins_.size() - 1);
    switch (choices_.below(begins_.size() > 1 ? 7 : 2)) {
      case 0: return choices_.mutated(text_, most_);
      case 1: set(kCounts + 4 * choices_.below(9), 4, choices_.number()); return text_;
      case 2: {  // once more
        const std::string part = text_.substr(begin(a), end(a) - begin(a));
        set_count(+1);
        return std::string(text_).insert(end(a), part);
      }
      case 3: set_count(-1); return text_.substr(0, begin(a)) + text_.substr(end(a));
      case 4: return with_size(begin(a));
      case 5: set(begin(a) + 2 + name_bytes(begin(a)) + 2, 4, choices_.below(7)); return text_;
      default: {  // a point more, or less
        const std::uint64_t points = get(kCounts + 4 * kCountOfPoints, 4);
        set(kCounts + 4 * kCountOfPoints, 4, points + (choices_.below(2) == 0 ? 1 : ~0ULL));
        return choices_.below(2) == 0 ? text_ + std::string(choices_.below(64), '\1') : text_;
      }
    }
  }

 private:
  [[nodiscard]] std::size_t begin(std::size_t a) const { return begins_[a]; }
  [[nodiscard]] std::size_t end(std::size_t a) const { return begins_[a + 1]; }

  [[nodiscard]] std::uint64_t get(std::size_t at, std::size_t bytes) const {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | static_cast<unsigned char>(text_[at + i]);
    return value;
  }
  void set(std::size_t at, std::size_t bytes, std::uint64_t value) {
    for (std::size_t i = 0; i < bytes && at + i < text_.size(); ++i) {
      text_[at + i] = static_cast<char>(value >> (8 * (bytes - 1 - i)));
    }
  }
  void set_count(int more) {
    const std::size_t at = kCounts + 4 * kCountOfAttributes;
    set(at, 4, get(at, 4) + static_cast<std::uint64_t>(static_cast<std::int64_t>(more)));
  }
  [[nodiscard]] std::size_t name_bytes(std::size_t at) const { return static_cast<std::size_t>(get(at, 2)); }

  // Another number of components, with defaults of its size.
  std::string with_size(std::size_t at) {
    const std::size_t field = at + 2 + name_bytes(at);
    const std::uint64_t before = get(field, 2);
    const std::uint64_t after = choices_.below(6);
    const std::uint64_t type = get(field + 2, 4);
    set(field, 2, after);
    if (type == 4) return text_;
    return std::string(text_).replace(field + 6, static_cast<std::size_t>(4 * before),
                                      std::string(static_cast<std::size_t>(4 * after), '\0'));
  }

  // Where the attributes begin, and where the last one ends, as far as they can be followed.
  void find_attributes() {
    std::size_t at = kAttributes;
    const std::uint64_t count = get(kCounts + 4 * kCountOfAttributes, 4);
    begins_.push_back(at);
    for (std::uint64_t a = 0; a < count && a < 64; ++a) {
      if (!pass(at, 2, 0) || !pass(at, 0, get(at - 2, 2)) || !pass(at, 6, 0)) return;
      const std::uint64_t size = get(at - 6, 2);
      if (get(at - 4, 4) != 4) {
        if (!pass(at, 0, 4 * size)) return;
      } else {
        if (!pass(at, 4, 0)) return;
        const std::uint64_t texts = get(at - 4, 4);
        for (std::uint64_t i = 0; i < texts; ++i) {
          if (!pass(at, 2, 0) || !pass(at, 0, get(at - 2, 2))) return;
        }
      }
      begins_.push_back(at);
    }
  }
  bool pass(std::size_t& at, std::size_t fixed, std::uint64_t more) const {
    if (fixed + more > text_.size() - at) return false;
    at += fixed + static_cast<std::size_t>(more);
    return true;
  }

  std::string text_;
  Choices choices_;
  std::size_t most_;
  std::vector<std::size_t> begins_;
};

}  // namespace
}  // namespace isoextract::fuzz

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  using namespace isoextract::fuzz;
  if (size < kAttributes) return LLVMFuzzerMutate(data, size, most);
  return give_back(Mutation({reinterpret_cast<const char*>(data), size}, seed, most).run(), data, size, most);
}

// A std::istream for OpenVDB to read from. OpenVDB takes the sizes in a file on trust; this stream does not: it throws
// VdbDamaged instead of reading past the end of the file or past what a node's buffer can hold. Private to io.
#pragma once

#include <cstdint>
#include <istream>
#include <memory>
#include <stdexcept>

#include "base/progress.hpp"
#include "io/file_bytes.hpp"

namespace isoextract {

// Thrown while a VDB file is read, and caught where io ends.
class VdbDamaged : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// How the values of a tree's nodes lie in the file.
struct VdbValueLayout {
  std::size_t value_size = 4;   // in memory
  std::size_t stored_size = 4;  // in the file: 2 if saved as half
  bool skips_empty = false;     // a node without values to store has no chunk at all: half floats only
  std::uint32_t compression = 0;
};

// VDB's compression flags.
inline constexpr std::uint32_t kVdbZip = 1;
inline constexpr std::uint32_t kVdbActiveMask = 2;
inline constexpr std::uint32_t kVdbBlosc = 4;

// Follows what OpenVDB reads of a tree and checks the sizes of the chunks of values. A node is: its masks; one byte
// that says which inactive values and which mask of them come next; those; then, where values are compressed, a size
// (negative: not compressed) and that many bytes. OpenVDB copies a chunk of negative size into a buffer of the
// expected size before it compares the two, and hands blosc chunks on without a word about their length.
class VdbNodeCheck {
 public:
  void start(const VdbValueLayout& layout);
  void stop() { started_ = false; }

  // To be told of every read: what came, and how many bytes are left in the file.
  void after_read(const char* bytes, std::uint64_t count, std::uint64_t left);

 private:
  enum class Next { masks, prefix, chunk_size, chunk };
  void choose_after_prefix();

  VdbValueLayout layout_;
  bool started_ = false;
  Next next_ = Next::masks;
  std::uint64_t mask_bits_ = 0;  // of the mask read last; 0 if the last read was none
  std::uint64_t mask_on_ = 0;
  int prefix_left_ = 0;
  bool masked_ = false;  // only active values are stored
  std::int64_t chunk_size_ = 0;
};

class VdbStream : public std::istream {
 public:
  explicit VdbStream(const InputFile& file, Progress* progress = nullptr);
  ~VdbStream() override;

  [[nodiscard]] std::uint64_t size() const;
  [[nodiscard]] std::uint64_t position();
  void seek(std::uint64_t position);

  // From now on reads are those of a tree; or, again, of something else.
  void expect_tree(const VdbValueLayout& layout);
  void expect_no_tree();

  template <class T>
  [[nodiscard]] T read_value() {
    T value{};
    read(reinterpret_cast<char*>(&value), sizeof value);
    return value;
  }
  // A length and that many characters. Lengths beyond any name's are damage.
  [[nodiscard]] std::string read_name();

 private:
  class Bytes;
  std::unique_ptr<Bytes> bytes_;
};

}  // namespace isoextract

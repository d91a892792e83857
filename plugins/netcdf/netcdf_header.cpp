// The classic header, as the NetCDF User's Guide defines it ("The NetCDF Classic Format Specification").
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "netcdf_parts.hpp"

namespace isoextract_netcdf {
namespace {

constexpr std::uint32_t kDimensions = 10;
constexpr std::uint32_t kVariables = 11;
constexpr std::uint32_t kAttributes = 12;

[[noreturn]] void refuse(const std::string& why) { throw ReadError("its netCDF header is damaged: " + why); }

std::uint64_t padded(std::uint64_t bytes) { return (bytes + 3) / 4 * 4; }

std::uint64_t type_size(std::uint64_t type) {
  constexpr std::array<std::uint64_t, 12> kSizes{0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
  if (type == 0 || type >= kSizes.size()) refuse("expected a data type from 1 to 11, found " + std::to_string(type));
  return kSizes[type];
}

// Reads big-endian numbers, never past the end of the file.
class HeaderReader {
 public:
  explicit HeaderReader(const std::string& path)
      : in_(path, std::ios::binary), size_(std::filesystem::file_size(path)) {
    std::array<char, 4> magic{};
    take(4, magic.data());
    version_ = magic[3];
  }

  [[nodiscard]] std::uint64_t size() const { return size_; }
  std::uint64_t count() { return number(version_ == 5 ? 8 : 4); }
  std::uint64_t offset() { return number(version_ == 1 ? 4 : 8); }
  std::uint64_t tag() { return number(4); }
  [[nodiscard]] bool is_streaming(std::uint64_t records) const {
    return records == (version_ == 5 ? ~std::uint64_t{0} : 0xFFFFFFFF);
  }

  void skip(std::uint64_t bytes) {
    if (bytes > size_ - at_) refuse("it ends after the file's " + std::to_string(size_) + " bytes");
    at_ += bytes;
    in_.seekg(static_cast<std::streamoff>(at_));
  }
  void skip_name() { skip_array(1); }
  // Skips a count, that many items of `item` bytes, and the padding to 4 bytes.
  void skip_array(std::uint64_t item) { skip(padded(items(item) * item)); }

  // Reads a count of items. Fails if the rest of the file has fewer than `least_bytes` for each.
  std::uint64_t items(std::uint64_t least_bytes) {
    const std::uint64_t found = count();
    if (found > (size_ - at_) / least_bytes)
      refuse("it counts " + std::to_string(found) + " items at byte " + std::to_string(at_) + " of " +
             std::to_string(size_));
    return found;
  }
  // Returns the number of items of a list; 0 if the list is absent.
  std::uint64_t list(std::uint32_t expected_tag) {
    const std::uint64_t found = tag();
    const std::uint64_t length = items(4);
    if (found != expected_tag && (found != 0 || length != 0)) {
      refuse("expected the list with tag " + std::to_string(expected_tag) + ", found tag " + std::to_string(found));
    }
    return length;
  }

 private:
  void take(std::uint64_t bytes, char* to) {
    if (bytes > size_ - at_ || !in_.read(to, static_cast<std::streamsize>(bytes)))
      refuse("it ends after the file's " + std::to_string(size_) + " bytes");
    at_ += bytes;
  }
  std::uint64_t number(std::size_t bytes) {
    std::array<char, 8> read{};
    take(bytes, read.data());
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | static_cast<unsigned char>(read[i]);
    return value;
  }

  std::ifstream in_;
  std::uint64_t size_ = 0;
  std::uint64_t at_ = 0;
  char version_ = 0;
};

void skip_attributes(HeaderReader& header) {
  const std::uint64_t count = header.list(kAttributes);
  for (std::uint64_t i = 0; i < count; ++i) {
    header.skip_name();
    header.skip_array(type_size(header.tag()));
  }
}

struct Stored {
  std::uint64_t begin = 0;
  std::uint64_t bytes = 0;  // of one record, or of all samples; not padded
  bool has_records = false;
};

std::uint64_t product(std::uint64_t a, std::uint64_t b) {
  std::uint64_t result = 0;
  if (__builtin_mul_overflow(a, b, &result)) refuse("a variable has more than 2^64 bytes");
  return result;
}

Stored read_variable_entry(HeaderReader& header, const std::vector<std::uint64_t>& dimensions) {
  Stored stored;
  header.skip_name();
  const std::uint64_t rank = header.items(4);
  std::uint64_t samples = 1;
  for (std::uint64_t i = 0; i < rank; ++i) {
    const std::uint64_t dimension = header.count();
    if (dimension >= dimensions.size()) {
      refuse("expected one of " + std::to_string(dimensions.size()) + " dimensions, found number " +
             std::to_string(dimension));
    }
    if (dimensions[dimension] == 0) {
      if (i != 0) refuse("the unlimited dimension is not a variable's first one");
      stored.has_records = true;
    } else {
      samples = product(samples, dimensions[dimension]);
    }
  }
  skip_attributes(header);
  stored.bytes = product(samples, type_size(header.tag()));
  header.count();  // the stored size, which is not needed and wrong for large variables
  stored.begin = header.offset();
  return stored;
}

}  // namespace

void check_classic_header(const std::string& path) {
  HeaderReader header(path);
  const std::uint64_t records = header.count();
  std::vector<std::uint64_t> dimensions(header.list(kDimensions));
  for (std::uint64_t& length : dimensions) {
    header.skip_name();
    length = header.count();
  }
  skip_attributes(header);
  std::vector<Stored> variables(header.list(kVariables));
  std::uint64_t record_bytes = 0;
  std::uint64_t record_variables = 0;
  for (Stored& variable : variables) {
    variable = read_variable_entry(header, dimensions);
    if (!variable.has_records) continue;
    ++record_variables;
    if (__builtin_add_overflow(record_bytes, padded(variable.bytes), &record_bytes))
      refuse("a record has more than 2^64 bytes");
  }
  for (const Stored& variable : variables) {
    std::uint64_t end = variable.bytes;
    if (variable.has_records) {
      if (records == 0 || header.is_streaming(records)) continue;
      // A single variable with records has no padding between them.
      end = product(records - 1, record_variables == 1 ? variable.bytes : record_bytes);
      if (__builtin_add_overflow(end, variable.bytes, &end)) refuse("a variable has more than 2^64 bytes");
    }
    if (__builtin_add_overflow(end, variable.begin, &end)) refuse("a variable has more than 2^64 bytes");
    if (end > header.size()) {
      throw ReadError("expected at least " + std::to_string(end) + " bytes by its header, found " +
                      std::to_string(header.size()));
    }
  }
}

}  // namespace isoextract_netcdf

// Checks the structure of a file before GDCM reads it: GDCM trusts lengths, and ends the process on many damaged files.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string_view>

#include <gdcmDataSet.h>
#include <gdcmException.h>
#include <gdcmExplicitDataElement.h>
#include <gdcmImplicitDataElement.h>
#include <gdcmSwapper.h>
#include <zlib.h>

#include "dicom_structure.hpp"

namespace isoextract_dicom {
namespace {

constexpr std::uint32_t kUndefined = 0xFFFFFFFFU;
constexpr std::uint32_t kItem = 0xFFFEE000U, kItemEnd = 0xFFFEE00DU, kSequenceEnd = 0xFFFEE0DDU;
constexpr std::string_view kExplicit = "1.2.840.10008.1.2.1", kDeflated = "1.2.840.10008.1.2.1.99";

// Value representations (VR) with a length field of 4 bytes, and of 2 bytes (PS3.5, 7.1.2).
constexpr std::string_view kLongKinds = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
constexpr std::string_view kShortKinds = "AE AS AT CS DA DS DT FL FD IS LO LT PN SH SL SS ST TM UI UL US";

// The bytes of a file, read in windows; of a deflated file, the inflated bytes in memory.
class Source {
 public:
  explicit Source(const std::string& path) : stream_(path, std::ios::binary), size_(std::filesystem::file_size(path)) {
    if (!stream_) throw ReadError("the file does not open");
  }
  explicit Source(const std::string* memory) : memory_(memory), size_(memory->size()) {}

  [[nodiscard]] std::uint64_t size() const { return size_; }
  // Returns `count` bytes. The caller has checked that the file has them.
  std::string_view at(std::uint64_t offset, std::size_t count) {
    if (memory_ != nullptr) return std::string_view(*memory_).substr(offset, count);
    if (offset < start_ || offset + count > start_ + window_.size()) {
      start_ = offset;
      window_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(std::max(count, kWindow), size_ - offset)));
      stream_.clear();
      stream_.seekg(static_cast<std::streamoff>(offset));
      if (!stream_.read(window_.data(), static_cast<std::streamsize>(window_.size())))
        throw ReadError("the file changed during the run");
    }
    return std::string_view(window_).substr(offset - start_, count);
  }

 private:
  static constexpr std::size_t kWindow = 16384;
  std::ifstream stream_;
  const std::string* memory_ = nullptr;
  std::uint64_t size_ = 0;
  std::uint64_t start_ = 0;
  std::string window_;
};

struct Element {
  std::uint32_t tag = 0;
  std::string kind;  // VR; empty if implicit
  std::uint32_t length = 0;
  std::uint64_t value = 0;  // offset of the value, in bytes
};

class Walker {
 public:
  Walker(Source& source, bool is_explicit, bool big_endian)
      : source_(source), explicit_(is_explicit), big_(big_endian) {}

  // Reads the header of an element, and checks that the header and the value end at or before `end`.
  Element element(std::uint64_t at, std::uint64_t end) {
    Element found;
    need(at, 8, end);
    found.tag = number(at, 2) << 16U | number(at + 2, 2);
    const bool is_delimiter = found.tag >> 16U == 0xFFFEU;
    if (!explicit_ || is_delimiter) {
      found.length = number(at + 4, 4);
      found.value = at + 8;
    } else {
      found.kind = std::string(source_.at(at + 4, 2));
      if (kLongKinds.find(found.kind) != std::string_view::npos && found.kind[0] != ' ' && found.kind[1] != ' ') {
        need(at, 12, end);
        found.length = number(at + 8, 4);
        found.value = at + 12;
      } else if (kShortKinds.find(found.kind) != std::string_view::npos && found.kind[0] != ' ' &&
                 found.kind[1] != ' ') {
        found.length = number(at + 6, 2);
        found.value = at + 8;
      } else {
        throw ReadError("expected a known type of value (VR) at byte " + std::to_string(at) +
                        ", found another: the header is damaged");
      }
    }
    if (found.length != kUndefined && found.length > end - found.value) {
      throw ReadError("expected an attribute of " + std::to_string(found.length) + " bytes at byte " +
                      std::to_string(at) + ", found " + std::to_string(end - found.value) +
                      " bytes to the end: the file ends early or has a damaged header");
    }
    return found;
  }

  // Returns the end of an element's value, after checking the items of a sequence.
  std::uint64_t skip(const Element& element, std::uint64_t end, int depth) {
    // GDCM misreads such elements, and then reads later attributes at wrong offsets.
    const bool is_delimiter = element.tag >> 16U == 0xFFFEU;
    const bool is_long_number = element.tag >> 16U == 9U && element.kind == "UL" && element.length == 6;
    if (is_delimiter || is_long_number)
      throw ReadError(std::string("expected an attribute before byte ") + std::to_string(element.value) + ", found " +
                      (is_delimiter ? "the start or end of an item" : "a number of 6 bytes") +
                      ": the header is damaged");
    const bool is_sequence = element.length == kUndefined || element.kind == "SQ";
    if (!is_sequence) return element.value + element.length;
    if (element.length == kUndefined && !element.kind.empty() && element.kind != "SQ" && element.kind != "UN")
      throw ReadError("expected an attribute of known length at byte " + std::to_string(element.value) +
                      ", found none: the header is damaged");
    // A sequence with VR UN has items with implicit VRs (PS3.5, 6.2.2).
    Walker items(source_, explicit_ && element.kind != "UN", big_);
    return items.skip_items(element.value, element.length == kUndefined ? end : element.value + element.length,
                            element.length == kUndefined, depth + 1);
  }

  // Checks items from `at` up to the sequence's delimiter or to `end`. Returns the offset after the sequence.
  std::uint64_t skip_items(std::uint64_t at, std::uint64_t end, bool has_delimiter, int depth) {
    if (depth > kDeepest)
      throw ReadError("expected at most " + std::to_string(kDeepest) + " nested sequences, found more");
    while (has_delimiter || at < end) {
      const Element item = element(at, end);
      if (item.tag == kSequenceEnd && has_delimiter) return item.value;
      if (item.tag != kItem)
        throw ReadError("expected an item of a sequence at byte " + std::to_string(at) +
                        ", found another attribute: the header is damaged");
      const bool is_open = item.length == kUndefined;
      const std::uint64_t item_end = is_open ? end : item.value + item.length;
      at = item.value;
      while (is_open || at < item_end) {
        const Element inner = element(at, item_end);
        if (is_open && inner.tag == kItemEnd) {
          at = inner.value;
          break;
        }
        at = skip(inner, item_end, depth);
      }
    }
    return at;
  }

 private:
  static constexpr int kDeepest = 32;

  void need(std::uint64_t at, std::uint64_t count, std::uint64_t end) const {
    if (at > end || count > end - at)
      throw ReadError("expected an attribute at byte " + std::to_string(at) + ", found the end: the file ends early");
  }
  std::uint32_t number(std::uint64_t at, std::size_t count) {
    std::uint32_t value = 0;
    const std::string_view bytes = source_.at(at, count);
    for (std::size_t i = 0; i < count; ++i)
      value = value << 8U | static_cast<unsigned char>(bytes[big_ ? i : count - 1 - i]);
    return value;
  }

  Source& source_;
  bool explicit_;
  bool big_;
};

std::string text_at(Source& source, const Element& element) {
  std::string text(source.at(element.value, std::min<std::uint32_t>(element.length, 128)));
  text.resize(std::min(text.size(), text.find('\0')));
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

// Reads the attributes of group 2. Returns the offset after the group.
std::uint64_t read_meta(Source& source, std::uint64_t at, Structure& structure) {
  Walker walker(source, true, false);
  while (at < source.size()) {
    if (source.size() - at >= 2 && source.at(at, 2) != std::string_view("\2\0", 2)) break;
    const Element element = walker.element(at, source.size());
    // PS3.10, 7.1: group 2 has no sequences. GDCM ends the process on one.
    if (element.kind == "SQ" || element.length == kUndefined)
      throw ReadError("expected an attribute of known length at byte " + std::to_string(at) +
                      ", found a sequence in the file's header: the header is damaged");
    if (element.tag == 0x00020002U) structure.class_uid = text_at(source, element);
    if (element.tag == 0x00020010U) structure.transfer_syntax = text_at(source, element);
    at = element.value + element.length;
  }
  return at;
}

void expect_object(std::uint64_t at, const Source& source) {
  if (at >= source.size())
    throw ReadError("expected a DICOM object after the file's header, found the end: the file ends early");
}

// Returns the bytes from `start` up to `end`, which are in the file.
std::string read_bytes(const std::string& path, std::uint64_t start, std::uint64_t end) {
  std::ifstream stream(path, std::ios::binary);
  std::string bytes(end - start, '\0');
  stream.seekg(static_cast<std::streamoff>(start));
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size())))
    throw ReadError("the file changed during the run");
  return bytes;
}

// Inflates the raw zlib stream from `start` to the end of a file.
std::shared_ptr<const std::string> inflate_file(const std::string& path, std::uint64_t start,
                                                const isoextract_plugin_host& host) {
  const std::uint64_t size = std::filesystem::file_size(path);
  isoextract_plugin::HostMemory memory(host);
  memory.take(size - start);
  std::string packed = read_bytes(path, start, size);
  auto whole = std::make_shared<std::string>();

  z_stream zlib{};
  if (inflateInit2(&zlib, -MAX_WBITS) != Z_OK) throw std::bad_alloc();
  struct End {
    z_stream* zlib;
    ~End() { inflateEnd(zlib); }
  } end{&zlib};
  zlib.next_in = reinterpret_cast<Bytef*>(packed.data());
  zlib.avail_in = static_cast<uInt>(std::min<std::uint64_t>(packed.size(), std::numeric_limits<uInt>::max()));
  constexpr std::size_t kStep = std::size_t{1} << 20U;
  int state = Z_OK;
  while (state == Z_OK) {
    isoextract_plugin::check_cancelled(host);
    memory.take(2 * kStep);  // the string may hold both its old and its new bytes
    const std::size_t before = whole->size();
    whole->resize(before + kStep);
    zlib.next_out = reinterpret_cast<Bytef*>(whole->data() + before);
    zlib.avail_out = kStep;
    state = inflate(&zlib, Z_NO_FLUSH);
    whole->resize(before + kStep - zlib.avail_out);
  }
  if (state != Z_STREAM_END) throw ReadError("expected deflated data, found damaged or cut ones");
  memory.keep();
  return whole;
}

}  // namespace

Structure check_structure(const std::string& path, const isoextract_plugin_host& host) {
  Structure structure;
  structure.path = path;
  auto source = std::make_unique<Source>(path);
  const bool has_preamble = source->size() >= 132 && source->at(128, 4) == "DICM";
  std::uint64_t at = read_meta(*source, has_preamble ? 132 : 0, structure);
  if (structure.transfer_syntax.empty() && has_preamble)
    throw ReadError("expected the transfer syntax of a DICOM file, found none: the header is damaged or cut");
  expect_object(at, *source);
  if (structure.transfer_syntax == kDeflated) {
    structure.inflated = inflate_file(path, at, host);
    source = std::make_unique<Source>(structure.inflated.get());
    at = 0;
    expect_object(at, *source);
    structure.transfer_syntax = kExplicit;
  }
  structure.start = at;
  structure.big_endian = structure.transfer_syntax == "1.2.840.10008.1.2.2";
  structure.is_explicit = structure.transfer_syntax != "1.2.840.10008.1.2";
  if (structure.transfer_syntax.empty()) {
    // An old file without group 2: two capital letters after the first tag mean explicit VRs.
    if (source->size() < 8)
      throw ReadError("expected a DICOM file, found " + std::to_string(source->size()) + " bytes");
    const std::string_view kind = source->at(4, 2);
    structure.is_explicit = kind[0] >= 'A' && kind[0] <= 'Z' && kind[1] >= 'A' && kind[1] <= 'Z';
    structure.transfer_syntax = structure.is_explicit ? kExplicit : "1.2.840.10008.1.2";
  }
  Walker walker(*source, structure.is_explicit, structure.big_endian);
  while (at < source->size()) {
    const Element element = walker.element(at, source->size());
    const bool is_pixels = element.tag == 0x7FE00008U || element.tag == 0x7FE00009U || element.tag == 0x7FE00010U;
    if (is_pixels) {
      structure.pixels = element.tag;
      structure.offset = element.value;
      structure.encapsulated = element.length == kUndefined;
      structure.bytes = structure.encapsulated ? 0 : element.length;
      break;
    }
    if (element.tag == 0x00080016U) structure.class_uid = text_at(*source, element);
    at = walker.skip(element, source->size(), 0);
  }
  structure.end = at;
  if (structure.end == structure.start)
    throw ReadError("expected attributes before the pixels, found none: the header is damaged");
  return structure;
}

void check_items(const std::string& value) {
  Source source(&value);
  Walker(source, false, false).skip_items(0, value.size(), false, 1);
}

void read_attributes(const Structure& structure, const isoextract_plugin_host& host, gdcm::DataSet& data) {
  const std::uint64_t size = structure.end - structure.start;
  isoextract_plugin::HostMemory memory(host);
  memory.take(2 * size);  // the stream has a copy
  std::istringstream stream(structure.inflated ? structure.inflated->substr(structure.start, size)
                                               : read_bytes(structure.path, structure.start, structure.end));
  try {
    if (!structure.is_explicit) {
      data.Read<gdcm::ImplicitDataElement, gdcm::SwapperNoOp>(stream);
    } else if (structure.big_endian) {
      data.Read<gdcm::ExplicitDataElement, gdcm::SwapperDoOp>(stream);
    } else {
      data.Read<gdcm::ExplicitDataElement, gdcm::SwapperNoOp>(stream);
    }
  } catch (const gdcm::Exception&) {
    throw ReadError("expected DICOM attributes, found some that GDCM cannot read");
  }
}

}  // namespace isoextract_dicom

// Reads samples of a page: decodes the strips or tiles that the box touches, one after another.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "images_tiff.hpp"

namespace isoextract_plugin {
namespace {

// Rows of decoded pixels: a strip, a tile, or a part of a plane.
struct Block {
  const unsigned char* data = nullptr;
  std::uint64_t row_bytes = 0;
  std::uint64_t x = 0, y = 0, width = 0, height = 0;  // in the page
  std::uint64_t samples = 1;                          // of a pixel in this block
};

// The box that receives the samples of a block.
struct Target {
  const PageBox& box;
  const PageShape& shape;
  void* to;
  std::uint64_t components;  // interleaved in `to`
};

// Reads sample i of a row with fewer than 16 bits each; the first sample has the highest bits of a byte.
std::uint32_t packed_sample(const unsigned char* row, std::uint64_t i, unsigned bits) {
  std::uint32_t value = 0;
  for (std::uint64_t bit = i * bits; bit < (i + 1) * bits; ++bit) {
    value = value << 1 | (row[bit / 8] >> (7 - bit % 8) & 1U);
  }
  return value;
}

// Copies the samples `first`, `first` + 1, ... of each pixel to components `at`, `at` + 1, ...; load(row, i) returns
// sample i of a row.
template <class T, class Load>
void copy_pixels(const Block& block, const Target& target, std::uint64_t first, std::uint64_t count, std::uint64_t at,
                 Load&& load) {
  const PageBox& box = target.box;
  const std::uint64_t x0 = std::max(block.x, box.x);
  const std::uint64_t x1 = std::min(block.x + block.width, box.x + box.width);
  const std::uint64_t y0 = std::max(block.y, box.y);
  const std::uint64_t y1 = std::min(block.y + block.height, box.y + box.height);
  for (std::uint64_t y = y0; y < y1; ++y) {
    const unsigned char* const row = block.data + (y - block.y) * block.row_bytes;
    T* to = static_cast<T*>(target.to) + ((y - box.y) * box.width + (x0 - box.x)) * target.components + at;
    for (std::uint64_t x = x0; x < x1; ++x, to += target.components) {
      const std::uint64_t i = (x - block.x) * block.samples + first;
      for (std::uint64_t c = 0; c < count; ++c) to[c] = load(row, i + c);
    }
  }
}

template <class T>
T element(const unsigned char* row, std::uint64_t i) {
  T value;
  std::memcpy(&value, row + i * sizeof(T), sizeof(T));
  return value;
}

// Returns a 16-bit float of a row.
float half_element(const unsigned char* row, std::uint64_t i) {
  const unsigned bits = element<std::uint16_t>(row, i);
  const unsigned exponent = bits >> 10U & 31U;
  const unsigned fraction = bits & 1023U;
  const float size = exponent == 0 ? std::ldexp(static_cast<float>(fraction), -24)
                     : exponent < 31U
                         ? std::ldexp(static_cast<float>(1024U + fraction), static_cast<int>(exponent) - 25)
                     : fraction == 0 ? std::numeric_limits<float>::infinity()
                                     : std::numeric_limits<float>::quiet_NaN();
  return (bits >> 15U) != 0 ? -size : size;
}

// Returns the 16-bit float nearest to a value.
double rounded_to_half(double value) {
  constexpr double kBeyond = 65520;  // rounds to infinity
  if (std::abs(value) >= kBeyond) return std::copysign(std::numeric_limits<double>::infinity(), value);
  int exponent = 0;
  static_cast<void>(std::frexp(value, &exponent));
  const int last_bit = std::max(exponent - 11, -24);
  return std::ldexp(std::nearbyint(std::ldexp(value, -last_bit)), last_bit);
}

// Copies a block's samples; load(row, i) returns one as stored.
template <class Load>
void copy_loaded(const Block& block, const Target& target, std::uint64_t first, std::uint64_t count, std::uint64_t at,
                 Load&& load) {
  using Stored = decltype(load(block.data, 0));
  const bool has_no_data = target.box.no_data.has_value();
  if (!has_no_data) {
    constexpr bool kIs64 = std::is_integral_v<Stored> && sizeof(Stored) == 8;
    using T = std::conditional_t<kIs64, double, Stored>;
    copy_pixels<T>(block, target, first, count, at,
                   [&](const unsigned char* row, std::uint64_t i) { return static_cast<T>(load(row, i)); });
    return;
  }
  const bool are_halves = type_of(target.shape).stored == ISOEXTRACT_F16;
  const double no_data = are_halves ? rounded_to_half(*target.box.no_data) : *target.box.no_data;
  const auto copy = [&]<class T>(T) {
    copy_pixels<T>(block, target, first, count, at, [&](const unsigned char* row, std::uint64_t i) {
      const Stored value = load(row, i);
      // GDAL writes the no-data value of float samples with fewer digits than a double has.
      const bool is_missing = static_cast<double>(value) == no_data ||
                              (std::is_same_v<Stored, float> && value == static_cast<Stored>(no_data));
      return is_missing ? std::numeric_limits<T>::quiet_NaN() : static_cast<T>(value);
    });
  };
  if (given_type(type_of(target.shape), has_no_data) == ISOEXTRACT_F64) {
    copy(double{});
  } else {
    copy(float{});
  }
}

// Copies a block's samples. `plane`: the block's component, if the page stores each component in its own blocks.
void copy_block(const Block& block, const Target& target, std::optional<std::uint64_t> plane) {
  const std::optional<std::uint64_t>& wanted = target.box.component;
  const std::uint64_t first = plane || !wanted ? 0 : *wanted;
  const std::uint64_t count = plane || wanted ? 1 : target.shape.samples;
  const std::uint64_t at = plane && !wanted ? *plane : 0;
  const auto copy = [&](auto&& load) { copy_loaded(block, target, first, count, at, load); };
  const auto bits = unsigned{target.shape.bits};
  const std::uint16_t format = target.shape.format;
  if (format == SAMPLEFORMAT_IEEEFP && bits == 64) return copy(element<double>);
  if (format == SAMPLEFORMAT_IEEEFP && bits == 32) return copy(element<float>);
  if (format == SAMPLEFORMAT_IEEEFP && bits == 16 && target.box.no_data) return copy(half_element);
  if (format == SAMPLEFORMAT_INT && bits == 64) return copy(element<std::int64_t>);
  if (format == SAMPLEFORMAT_INT && bits == 32) return copy(element<std::int32_t>);
  if (format == SAMPLEFORMAT_INT && bits == 16) return copy(element<std::int16_t>);
  if (format == SAMPLEFORMAT_INT && bits == 8) return copy(element<std::int8_t>);
  if (bits == 64) return copy(element<std::uint64_t>);
  if (bits == 32) return copy(element<std::uint32_t>);
  if (bits == 16) return copy(element<std::uint16_t>);  // the bits of halves as well
  if (bits == 8) return copy(element<std::uint8_t>);
  if (bits < 8) {
    return copy([bits](const unsigned char* row, std::uint64_t i) {
      return static_cast<std::uint8_t>(packed_sample(row, i, bits));
    });
  }
  copy([bits](const unsigned char* row, std::uint64_t i) {
    return static_cast<std::uint16_t>(packed_sample(row, i, bits));
  });
}

// Bytes of a block, which grow as needed.
class Buffer {
 public:
  explicit Buffer(const isoextract_plugin_host& host) : memory_(host) {}
  unsigned char* of_size(std::uint64_t bytes) {
    if (bytes > bytes_.size()) {
      memory_.take(bytes - bytes_.size());
      bytes_.resize(bytes);
    }
    return bytes_.data();
  }

 private:
  HostMemory memory_;
  std::vector<unsigned char> bytes_;
};

// Decodes a strip or tile; fills with 0 if the file leaves it out.
void decode(const Tiff& tiff, std::uint32_t number, bool is_tile, unsigned char* to, std::uint64_t bytes) {
  int failed = 0;
  const std::uint64_t offset = TIFFGetStrileOffsetWithErr(tiff.get(), number, &failed);
  const std::uint64_t stored = failed != 0 ? 0 : TIFFGetStrileByteCountWithErr(tiff.get(), number, &failed);
  if (failed != 0) tiff.fail("libtiff cannot read the table of its strips or tiles");
  if (offset == 0 && stored == 0) {
    std::memset(to, 0, bytes);
    return;
  }
  const auto size = static_cast<tmsize_t>(bytes);
  const tmsize_t got =
      is_tile ? TIFFReadEncodedTile(tiff.get(), number, to, size) : TIFFReadEncodedStrip(tiff.get(), number, to, size);
  if (got != size) tiff.fail(std::string(is_tile ? "tile " : "strip ") + std::to_string(number) + " ends early");
}

void read_tiles(const Tiff& tiff, const Target& target, std::uint64_t samples, std::optional<std::uint64_t> plane,
                Buffer& buffer, const isoextract_plugin_host& host) {
  TIFF* const file = tiff.get();
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  TIFFGetField(file, TIFFTAG_TILEWIDTH, &width);
  TIFFGetField(file, TIFFTAG_TILELENGTH, &height);
  const std::uint64_t bytes = TIFFTileSize64(file);
  const std::uint64_t row_bytes = TIFFTileRowSize64(file);
  if (width == 0 || height == 0 || row_bytes == 0 || bytes < row_bytes * height ||
      row_bytes < (width * samples * target.shape.bits + 7) / 8) {
    tiff.fail("its tiles have no valid size");
  }
  unsigned char* const data = buffer.of_size(bytes);
  const PageBox& box = target.box;
  for (std::uint64_t y = box.y / height * height; y < box.y + box.height; y += height) {
    check_cancelled(host);
    for (std::uint64_t x = box.x / width * width; x < box.x + box.width; x += width) {
      const std::uint32_t number = TIFFComputeTile(file, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                                                   0, static_cast<std::uint16_t>(plane.value_or(0)));
      decode(tiff, number, true, data, bytes);
      copy_block({data, row_bytes, x, y, width, height, samples}, target, plane);
    }
  }
}

void read_strips(const Tiff& tiff, const Target& target, std::uint64_t samples, std::optional<std::uint64_t> plane,
                 Buffer& buffer, const isoextract_plugin_host& host) {
  TIFF* const file = tiff.get();
  std::uint32_t rows = target.shape.height;
  TIFFGetFieldDefaulted(file, TIFFTAG_ROWSPERSTRIP, &rows);
  rows = std::clamp<std::uint32_t>(rows, 1, target.shape.height);
  const std::uint64_t row_bytes = TIFFScanlineSize64(file);
  if (row_bytes < (std::uint64_t{target.shape.width} * samples * target.shape.bits + 7) / 8) {
    tiff.fail("its rows have no valid size");
  }
  const PageBox& box = target.box;
  for (std::uint64_t y = box.y / rows * rows; y < box.y + box.height; y += rows) {
    check_cancelled(host);
    const std::uint64_t height = std::min<std::uint64_t>(rows, target.shape.height - y);
    const std::uint64_t bytes = checked_product(row_bytes, height);
    unsigned char* const data = buffer.of_size(bytes);
    const std::uint32_t number =
        TIFFComputeStrip(file, static_cast<std::uint32_t>(y), static_cast<std::uint16_t>(plane.value_or(0)));
    decode(tiff, number, false, data, bytes);
    copy_block({data, row_bytes, 0, y, target.shape.width, height, samples}, target, plane);
  }
}

// Reads the rows of an uncompressed plane at `offset`, which has no page (directory) of its own.
void read_plane(const Tiff& tiff, std::uint64_t offset, const Target& target, Buffer& buffer) {
  const PageShape& shape = target.shape;
  const std::uint64_t pixel = std::uint64_t{shape.samples} * shape.bits / 8;
  const std::uint64_t row_bytes = shape.width * pixel;
  const std::uint64_t bytes = checked_product(row_bytes, target.box.height);
  unsigned char* const data = buffer.of_size(bytes);
  TIFFSeekProc seek = TIFFGetSeekProc(tiff.get());
  TIFFReadWriteProc read = TIFFGetReadProc(tiff.get());
  const std::uint64_t at = offset + target.box.y * row_bytes;
  if (seek(TIFFClientdata(tiff.get()), at, SEEK_SET) != at) tiff.fail("expected a plane where the file ends");
  if (read(TIFFClientdata(tiff.get()), data, static_cast<tmsize_t>(bytes)) != static_cast<tmsize_t>(bytes)) {
    tiff.fail("a plane ends early");
  }
  if (TIFFIsByteSwapped(tiff.get()) != 0) {
    const std::uint64_t size = shape.bits / 8;
    for (std::uint64_t i = 0; i < bytes; i += size) std::reverse(data + i, data + i + size);
  }
  copy_block({data, row_bytes, 0, target.box.y, shape.width, target.box.height, shape.samples}, target, {});
}

}  // namespace

PageType type_of(const PageShape& shape) {
  const std::string bits = std::to_string(shape.bits);
  if (shape.format == SAMPLEFORMAT_IEEEFP) {
    if (shape.bits == 16) return {ISOEXTRACT_F16, "half"};
    if (shape.bits == 32) return {ISOEXTRACT_F32, "float"};
    if (shape.bits == 64) return {ISOEXTRACT_F64, "double"};
    return {ISOEXTRACT_NOT_SCALAR, "float" + bits};
  }
  if (shape.format == SAMPLEFORMAT_INT) {
    if (shape.bits == 8) return {ISOEXTRACT_I8, "int8"};
    if (shape.bits == 16) return {ISOEXTRACT_I16, "int16"};
    if (shape.bits == 32) return {ISOEXTRACT_I32, "int32"};
    if (shape.bits == 64) return {ISOEXTRACT_F64, "int64", true};
    return {ISOEXTRACT_NOT_SCALAR, "int" + bits};
  }
  if (shape.format == SAMPLEFORMAT_UINT) {
    if (shape.bits >= 1 && shape.bits <= 8) return {ISOEXTRACT_U8, "uint" + bits};
    if (shape.bits <= 16) return {ISOEXTRACT_U16, "uint" + bits};
    if (shape.bits == 32) return {ISOEXTRACT_U32, "uint32"};
    if (shape.bits == 64) return {ISOEXTRACT_F64, "uint64", true};
    return {ISOEXTRACT_NOT_SCALAR, "uint" + bits};
  }
  return {ISOEXTRACT_NOT_SCALAR, "complex"};
}

std::int32_t given_type(const PageType& type, bool has_no_data) {
  if (!has_no_data || type.stored == ISOEXTRACT_NOT_SCALAR) return type.stored;
  const bool is_wide = type.stored == ISOEXTRACT_F64 || type.stored == ISOEXTRACT_U32 || type.stored == ISOEXTRACT_I32;
  return is_wide ? ISOEXTRACT_F64 : ISOEXTRACT_F32;
}

void read_page(Tiff& tiff, const Page& page, const PageBox& box, void* to, const isoextract_plugin_host& host) {
  tiff.select(page.directory);
  Buffer buffer(host);
  const Target target{box, page.shape, to, box.component ? 1 : std::uint64_t{page.shape.samples}};
  if (page.plane) return read_plane(tiff, *page.plane, target, buffer);
  TIFF* const file = tiff.get();
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint16_t planes = PLANARCONFIG_CONTIG;
  std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
  std::uint16_t compression = COMPRESSION_NONE;
  TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(file, TIFFTAG_IMAGELENGTH, &height);
  TIFFGetFieldDefaulted(file, TIFFTAG_PLANARCONFIG, &planes);
  TIFFGetFieldDefaulted(file, TIFFTAG_PHOTOMETRIC, &photometric);
  TIFFGetFieldDefaulted(file, TIFFTAG_COMPRESSION, &compression);
  if (width != page.shape.width || height != page.shape.height) throw ReadError("the file changed during the run");
  if (TIFFIsCODECConfigured(compression) == 0) {
    throw ReadError("its compression " + std::to_string(compression) + ", which this libtiff does not have");
  }
  if (photometric == PHOTOMETRIC_YCBCR) {
    if (compression == COMPRESSION_JPEG) {
      TIFFSetField(file, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    } else {
      throw ReadError("expected samples of gray or RGB, found YCbCr colors");
    }
  }
  const auto read = [&](std::uint64_t samples, std::optional<std::uint64_t> plane) {
    if (TIFFIsTiled(file) != 0) {
      read_tiles(tiff, target, samples, plane, buffer, host);
    } else {
      read_strips(tiff, target, samples, plane, buffer, host);
    }
  };
  if (planes != PLANARCONFIG_SEPARATE || page.shape.samples == 1) return read(page.shape.samples, {});
  for (std::uint64_t plane = 0; plane < page.shape.samples; ++plane) {
    if (!box.component || *box.component == plane) read(1, plane);
  }
}

}  // namespace isoextract_plugin

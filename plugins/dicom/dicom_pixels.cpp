// Decodes pixels frame by frame: reads uncompressed frames itself, and has GDCM decode compressed ones.
#include <algorithm>
#include <bit>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>

#include <gdcmFragment.h>
#include <gdcmImage.h>
#include <gdcmJPEG2000Codec.h>
#include <gdcmJPEGCodec.h>
#include <gdcmJPEGLSCodec.h>
#include <gdcmSequenceOfFragments.h>

#include "dicom_parts.hpp"

namespace isoextract_dicom {
namespace {

std::uint64_t native_bytes(const Pixels& pixels, std::uint64_t frames) {
  return (pixels.samples() * frames * pixels.bits_allocated + 7) / 8;
}

// A fragment (item) of encapsulated pixel data.
struct Piece {
  std::uint64_t offset = 0;
  std::uint32_t bytes = 0;
};

// The pieces of every frame (PS3.5, A.4).
class PieceTable {
 public:
  PieceTable(std::istream& stream, const Pixels& pixels) {
    const std::uint64_t size = std::filesystem::file_size(pixels.path);
    std::uint64_t at = pixels.offset;
    std::optional<Piece> offsets;
    while (true) {
      const auto [tag, bytes] = item_at(stream, at);
      if (tag == kSequenceEnd) break;
      at += 8;
      if (tag != kItem || bytes > size - at)
        throw ReadError("expected " + std::to_string(pixels.frames) + " compressed frames, found a damaged or cut one");
      if (offsets) {
        pieces_.push_back({at, bytes});
      } else {
        offsets = Piece{at, bytes};
      }
      at += bytes;
    }
    assign(stream, pixels, offsets.value_or(Piece{}));
  }

  [[nodiscard]] const std::vector<Piece>& pieces() const { return pieces_; }
  // Returns the first and last piece (excluded) of a frame.
  [[nodiscard]] std::pair<std::size_t, std::size_t> of(std::uint32_t frame) const {
    return {first_[frame], first_[frame + 1]};
  }

 private:
  static constexpr std::uint32_t kItem = 0xE000FFFEU;
  static constexpr std::uint32_t kSequenceEnd = 0xE0DDFFFEU;

  static std::uint32_t word_at(std::istream& stream, std::uint64_t at) {
    std::array<unsigned char, 4> b{};
    stream.clear();
    stream.seekg(static_cast<std::streamoff>(at));
    if (!stream.read(reinterpret_cast<char*>(b.data()), 4))
      throw ReadError("expected compressed frames, found the end of the file");
    return b[0] | std::uint32_t{b[1]} << 8U | std::uint32_t{b[2]} << 16U | std::uint32_t{b[3]} << 24U;
  }
  static std::pair<std::uint32_t, std::uint32_t> item_at(std::istream& stream, std::uint64_t at) {
    return {word_at(stream, at), word_at(stream, at + 4)};
  }

  void assign(std::istream& stream, const Pixels& pixels, const Piece& offsets) {
    const std::size_t count = pieces_.size();
    if (pixels.frames == 1 && count > 0) {
      first_ = {0, count};
    } else if (count == pixels.frames) {
      for (std::size_t i = 0; i <= count; ++i) first_.push_back(i);
    } else if (count > pixels.frames && offsets.bytes == 4 * std::uint64_t{pixels.frames}) {
      // The table's offsets count from the first item after the table.
      const std::uint64_t base = offsets.offset + offsets.bytes + 8;
      for (std::uint32_t i = 0; i < pixels.frames; ++i) {
        const std::uint64_t at = base + word_at(stream, offsets.offset + 4 * std::uint64_t{i});
        const auto found = std::ranges::find(pieces_, at, &Piece::offset);
        const auto place = static_cast<std::size_t>(found - pieces_.begin());
        if (found == pieces_.end() || (i > 0 && place <= first_.back()))
          throw ReadError("expected frame offsets that increase and point to items, found other offsets");
        first_.push_back(place);
      }
      first_.push_back(count);
    } else {
      throw ReadError("expected " + std::to_string(pixels.frames) + " compressed frames, found " +
                      std::to_string(count));
    }
  }

  std::vector<Piece> pieces_;
  std::vector<std::size_t> first_;
};

// Throws unless a compressed frame has the width, height and bytes per pixel of the DICOM header. GDCM trusts one of
// the two without a comparison.
template <class Codec>
void check_codestream(const Pixels& pixels, const std::string& codestream) {
  Codec codec;
  if (!codec.CanDecode(gdcm::TransferSyntax::GetTSType(pixels.transfer_syntax.c_str()))) return;
  codec.SetPixelFormat(gdcm::PixelFormat(static_cast<unsigned short>(pixels.samples_per_pixel),
                                         static_cast<unsigned short>(pixels.bits_allocated),
                                         static_cast<unsigned short>(pixels.bits_stored),
                                         static_cast<unsigned short>(pixels.high_bit), pixels.is_signed ? 1 : 0));
  std::istringstream stream(codestream);
  gdcm::TransferSyntax syntax;
  if (!codec.GetHeaderInfo(stream, syntax)) throw ReadError("expected a compressed image, found a damaged one");
  const unsigned int* const dims = codec.GetDimensions();
  const gdcm::PixelFormat& format = codec.GetPixelFormat();
  const std::uint32_t expected_bytes = pixels.samples_per_pixel * pixels.bits_allocated / 8;
  if (dims[0] != pixels.columns || dims[1] != pixels.rows || format.GetPixelSize() != expected_bytes) {
    const auto size = [](std::uint64_t x, std::uint64_t y, std::uint64_t bytes) {
      return std::to_string(x) + " x " + std::to_string(y) + " pixels of " + std::to_string(bytes) + " bytes";
    };
    throw ReadError("expected a compressed image of " + size(pixels.columns, pixels.rows, expected_bytes) +
                    " as the header says, found " + size(dims[0], dims[1], format.GetPixelSize()));
  }
}

// Keeps the stored bits of each sample. `shift`: the number of unused bits below the stored ones.
template <class T>
void keep_stored_bits(T* values, std::size_t count, std::uint32_t stored, std::uint32_t shift, bool is_signed) {
  using Bits = std::make_unsigned_t<T>;
  constexpr std::uint32_t kAllBits = sizeof(T) * 8;
  if (stored == kAllBits) return;
  const auto mask = static_cast<Bits>((Bits{1} << stored) - 1U);
  const auto sign = static_cast<Bits>(Bits{1} << (stored - 1));
  for (std::size_t i = 0; i < count; ++i) {
    auto bits = static_cast<Bits>(static_cast<Bits>(static_cast<Bits>(values[i]) >> shift) & mask);
    if (is_signed && (bits & sign) != 0) bits = static_cast<Bits>(bits | static_cast<Bits>(~mask));
    values[i] = static_cast<T>(bits);
  }
}

template <class T>
void swap_bytes(T* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    auto* const bytes = reinterpret_cast<unsigned char*>(values + i);
    std::reverse(bytes, bytes + sizeof(T));
  }
}

}  // namespace

std::int32_t sample_type(const Pixels& pixels) {
  if (pixels.is_float) return pixels.bits_allocated == 64 ? ISOEXTRACT_F64 : ISOEXTRACT_F32;
  switch (pixels.bits_allocated) {
    case 1: return ISOEXTRACT_U8;
    case 8: return pixels.is_signed ? ISOEXTRACT_I8 : ISOEXTRACT_U8;
    case 16: return pixels.is_signed ? ISOEXTRACT_I16 : ISOEXTRACT_U16;
    case 32: return pixels.is_signed ? ISOEXTRACT_I32 : ISOEXTRACT_U32;
    default: return ISOEXTRACT_NOT_SCALAR;
  }
}

std::string form_problem(const Pixels& pixels) {
  if (pixels.columns == 0 || pixels.rows == 0)
    return "expected an image with rows and columns, found " + std::to_string(pixels.columns) + " x " +
           std::to_string(pixels.rows) + " pixels";
  const std::uint32_t bits = pixels.bits_allocated;
  const bool known = pixels.is_float ? bits == 32 || bits == 64
                                     : bits == 8 || bits == 16 || bits == 32 || (bits == 1 && !pixels.encapsulated);
  if (!known)
    return "expected pixels of 1, 8, 16 or 32 bits, found " + std::to_string(bits) +
           (pixels.encapsulated ? " in compressed images" : "");
  if (!pixels.is_float && (pixels.bits_stored == 0 || pixels.bits_stored > bits || pixels.high_bit >= bits ||
                           pixels.high_bit + 1 < pixels.bits_stored)) {
    return "expected stored bits within the " + std::to_string(bits) + " bits of a pixel, found " +
           std::to_string(pixels.bits_stored) + " bits up to bit " + std::to_string(pixels.high_bit);
  }
  if (pixels.samples_per_pixel != 1 && pixels.samples_per_pixel != 3 && pixels.samples_per_pixel != 4)
    return "expected 1, 3 or 4 samples per pixel, found " + std::to_string(pixels.samples_per_pixel);
  if (bits == 1 && pixels.samples_per_pixel != 1)
    return "expected one sample per pixel of one bit, found " + std::to_string(pixels.samples_per_pixel);
  if (!pixels.encapsulated && (pixels.photometric == "YBR_FULL_422" || pixels.photometric.starts_with("YBR_PARTIAL")))
    return "expected colors at every pixel, found subsampled ones (" + pixels.photometric + ")";
  const gdcm::TransferSyntax syntax(gdcm::TransferSyntax::GetTSType(pixels.transfer_syntax.c_str()));
  if (pixels.encapsulated) {
    if (!syntax.IsEncapsulated() || syntax == gdcm::TransferSyntax::MPEG2MainProfile ||
        syntax == gdcm::TransferSyntax::MPEG2MainProfileHighLevel ||
        syntax == gdcm::TransferSyntax::MPEG4AVCH264HighProfileLevel4_1 ||
        syntax == gdcm::TransferSyntax::MPEG4AVCH264BDcompatibleHighProfileLevel4_1)
      return "expected JPEG, JPEG-LS, JPEG 2000 or RLE compression, found transfer syntax " + pixels.transfer_syntax;
  }
  if (!pixels.encapsulated && syntax.IsEncapsulated())
    return "expected frames in pieces for transfer syntax " + pixels.transfer_syntax + ", found one value";
  return {};
}

void check_size(const Pixels& pixels) {
  if (pixels.encapsulated) {
    std::ifstream stream(pixels.path, std::ios::binary);
    const PieceTable checked(stream, pixels);
    return;
  }
  const std::uint64_t needed = native_bytes(pixels, pixels.frames);
  const std::uint64_t there = pixels.bytes;
  if (needed > there) {
    throw ReadError("expected " + std::to_string(needed) + " bytes of pixels (" + std::to_string(pixels.columns) +
                    " x " + std::to_string(pixels.rows) + " x " + std::to_string(pixels.frames) + "), found " +
                    std::to_string(there));
  }
}

struct PixelReader::Parts {
  Pixels pixels;
  std::ifstream stream;
  std::optional<PieceTable> table;
  std::vector<std::byte> decoded;

  void read(std::uint64_t offset, std::uint64_t bytes, char* to) {
    if (pixels.inflated) {
      std::copy_n(pixels.inflated->data() + pixels.offset + offset, bytes, to);
      return;
    }
    stream.clear();
    stream.seekg(static_cast<std::streamoff>(pixels.offset + offset));
    if (!stream.read(to, static_cast<std::streamsize>(bytes)))
      throw ReadError("the file changed during the run: pixels are missing");
  }

  void decode_bits(std::uint32_t index) {
    const std::uint64_t first_bit = index * pixels.samples();
    const std::uint64_t first_byte = first_bit / 8;
    std::vector<char> packed((first_bit + pixels.samples() + 7) / 8 - first_byte);
    read(first_byte, packed.size(), packed.data());
    for (std::uint64_t i = 0; i < decoded.size(); ++i) {
      const std::uint64_t bit = first_bit + i - first_byte * 8;
      decoded[i] = static_cast<std::byte>(static_cast<unsigned char>(packed[bit / 8]) >> (bit % 8) & 1U);
    }
  }

  void decompress(std::uint32_t index) {
    const auto [first, last] = table->of(index);
    gdcm::SmartPointer<gdcm::SequenceOfFragments> fragments = new gdcm::SequenceOfFragments;
    std::string codestream;
    for (std::size_t i = first; i < last; ++i) {
      const Piece& piece = table->pieces()[i];
      std::string bytes(piece.bytes, '\0');
      read(piece.offset - pixels.offset, piece.bytes, bytes.data());
      codestream += bytes;
    }
    check_codestream<gdcm::JPEG2000Codec>(pixels, codestream);
    check_codestream<gdcm::JPEGLSCodec>(pixels, codestream);
    check_codestream<gdcm::JPEGCodec>(pixels, codestream);
    gdcm::Fragment fragment;
    fragment.SetByteValue(codestream.data(), gdcm::VL(static_cast<std::uint32_t>(codestream.size())));
    fragments->AddFragment(fragment);
    gdcm::DataElement element(gdcm::Tag(0x7fe0, 0x0010));
    element.SetVR(gdcm::VR::OB);
    element.SetValue(*fragments);

    gdcm::Image image;
    image.SetNumberOfDimensions(2);
    image.SetDimension(0, pixels.columns);
    image.SetDimension(1, pixels.rows);
    image.SetPixelFormat(gdcm::PixelFormat(static_cast<unsigned short>(pixels.samples_per_pixel),
                                           static_cast<unsigned short>(pixels.bits_allocated),
                                           static_cast<unsigned short>(pixels.bits_stored),
                                           static_cast<unsigned short>(pixels.high_bit), pixels.is_signed ? 1 : 0));
    image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::GetPIType(pixels.photometric.c_str()));
    image.SetPlanarConfiguration(pixels.planar ? 1 : 0);
    image.SetTransferSyntax(gdcm::TransferSyntax::GetTSType(pixels.transfer_syntax.c_str()));
    image.SetDataElement(element);
    if (image.GetBufferLength() != decoded.size() || !image.GetBuffer(reinterpret_cast<char*>(decoded.data())))
      throw ReadError("expected a compressed image, found one that GDCM cannot decode");
  }
};

PixelReader::PixelReader(const Pixels& pixels) : parts_(std::make_unique<Parts>()) {
  parts_->pixels = pixels;
  parts_->stream.open(pixels.path, std::ios::binary);
  if (!parts_->stream) throw ReadError("the file changed during the run: it does not open");
  if (pixels.encapsulated) parts_->table.emplace(parts_->stream, pixels);
  parts_->decoded.resize(pixels.samples() * isoextract_plugin::sample_size(sample_type(pixels)));
}

PixelReader::~PixelReader() = default;

const std::vector<std::byte>& PixelReader::frame(std::uint32_t index) {
  const Pixels& pixels = parts_->pixels;
  std::vector<std::byte>& decoded = parts_->decoded;
  if (pixels.bits_allocated == 1) {
    parts_->decode_bits(index);
    return decoded;
  }
  const bool swaps = !pixels.encapsulated && pixels.big_endian != (std::endian::native == std::endian::big);
  if (pixels.encapsulated) {
    parts_->decompress(index);
  } else {
    parts_->read(index * decoded.size(), decoded.size(), reinterpret_cast<char*>(decoded.data()));
  }
  isoextract_plugin::with_sample_type(sample_type(pixels), [&]<class T>(T) {
    T* const values = reinterpret_cast<T*>(decoded.data());
    if (swaps) swap_bytes(values, pixels.samples());
    if constexpr (std::is_integral_v<T>) {
      const std::uint32_t shift = pixels.encapsulated ? 0 : pixels.high_bit + 1 - pixels.bits_stored;
      keep_stored_bits(values, pixels.samples(), pixels.bits_stored, shift, pixels.is_signed);
    }
  });
  return decoded;
}

}  // namespace isoextract_dicom

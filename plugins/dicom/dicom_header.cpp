// Headers of objects, read up to the pixels.
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>

#include <gdcmMediaStorage.h>
#include <gdcmReader.h>

#include "dicom_dataset.hpp"

namespace isoextract_dicom {
namespace {

const gdcm::Tag kFloatPixels(0x7fe0, 0x0008), kDoublePixels(0x7fe0, 0x0009), kPixels(0x7fe0, 0x0010);

std::uint32_t number_at(const unsigned char* bytes, std::size_t count, bool big_endian) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8U | bytes[big_endian ? i : count - 1 - i];
  return value;
}

bool is_tag(const unsigned char* bytes, const gdcm::Tag& tag, bool big_endian) {
  return number_at(bytes, 2, big_endian) == tag.GetGroup() && number_at(bytes + 2, 2, big_endian) == tag.GetElement();
}

// The stream is at the value of the pixels if what precedes it is their tag and length: with a VR, 4 + 2 + 2 + 4 bytes,
// or without one, 4 + 4 bytes.
bool locate_value(std::istream& stream, const gdcm::Tag& tag, Pixels& pixels) {
  if (!stream.good()) return false;
  const auto at = static_cast<std::streamoff>(stream.tellg());
  std::array<unsigned char, 12> before{};
  if (at < static_cast<std::streamoff>(before.size())) return false;
  stream.seekg(at - 12);
  if (!stream.read(reinterpret_cast<char*>(before.data()), before.size())) return false;
  if (!is_tag(before.data(), tag, pixels.big_endian) && !is_tag(before.data() + 4, tag, pixels.big_endian))
    return false;
  const std::uint32_t length = number_at(before.data() + 8, 4, pixels.big_endian);
  pixels.offset = static_cast<std::uint64_t>(at);
  pixels.encapsulated = length == 0xFFFFFFFFU;
  pixels.bytes = pixels.encapsulated ? 0 : length;
  return true;
}

// Reads a header into `reader` up to a tag; returns whether that tag was found.
bool read_up_to(gdcm::Reader& reader, std::ifstream& stream, const std::string& path, const gdcm::Tag& tag,
                Pixels& pixels) {
  stream.open(path, std::ios::binary);
  if (!stream) throw ReadError("the file cannot be opened");
  reader.SetStream(stream);
  if (!reader.ReadUpToTag(tag, {kFloatPixels, kDoublePixels, kPixels})) {
    if (reader.GetFile().GetHeader().GetDataSetTransferSyntax() != gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian)
      throw ReadError("expected a DICOM header, found a damaged or cut one");
  }
  const gdcm::TransferSyntax& syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
  pixels.transfer_syntax = syntax.GetString() == nullptr ? "" : syntax.GetString();
  pixels.big_endian = syntax == gdcm::TransferSyntax::ExplicitVRBigEndian;
  return locate_value(stream, tag, pixels);
}

void read_layout(const gdcm::DataSet& data, Pixels& pixels) {
  pixels.rows = short_of(data, gdcm::Tag(0x0028, 0x0010)).value_or(0);
  pixels.columns = short_of(data, gdcm::Tag(0x0028, 0x0011)).value_or(0);
  const double frames = decimal_of(data, gdcm::Tag(0x0028, 0x0008)).value_or(1);
  constexpr double kMostFrames = 1 << 24;
  if (!(frames >= 1 && frames <= kMostFrames)) {
    throw ReadError("expected a number of frames from 1 to " + number_text(kMostFrames) + ", found " +
                    number_text(frames));
  }
  pixels.frames = static_cast<std::uint32_t>(frames);
  pixels.samples_per_pixel = short_of(data, gdcm::Tag(0x0028, 0x0002)).value_or(1);
  pixels.planar = short_of(data, gdcm::Tag(0x0028, 0x0006)).value_or(0) == 1;
  pixels.bits_allocated = short_of(data, gdcm::Tag(0x0028, 0x0100)).value_or(pixels.is_float ? 32 : 0);
  pixels.bits_stored = short_of(data, gdcm::Tag(0x0028, 0x0101)).value_or(pixels.bits_allocated);
  pixels.high_bit = short_of(data, gdcm::Tag(0x0028, 0x0102)).value_or(pixels.bits_stored - 1);
  pixels.is_signed = short_of(data, gdcm::Tag(0x0028, 0x0103)).value_or(0) == 1;
  pixels.photometric = text_of(data, gdcm::Tag(0x0028, 0x0004));
}

// A deflated file has no position of its pixels: they are kept in memory.
bool inflate(const std::string& path, const isoextract_plugin_host& host, Pixels& pixels) {
  isoextract_plugin::HostMemory memory(host);
  memory.take(2 * (pixels.samples() * pixels.frames * pixels.bits_allocated / 8 + 1));
  std::ifstream stream(path, std::ios::binary);
  gdcm::Reader reader;
  reader.SetStream(stream);
  static_cast<void>(reader.Read());  // false even for whole files; the size of the pixels is checked
  const gdcm::DataSet& data = reader.GetFile().GetDataSet();
  if (!data.FindDataElement(kPixels)) return false;
  const gdcm::ByteValue* const bytes = data.GetDataElement(kPixels).GetByteValue();
  if (bytes == nullptr) return false;
  pixels.inflated =
      std::make_shared<const std::vector<char>>(bytes->GetPointer(), bytes->GetPointer() + bytes->GetLength());
  pixels.bytes = pixels.inflated->size();
  memory.keep();
  return true;
}

// Returns whether a text has a part of the patient's name, or the patient's identity, at least three characters long.
bool names_patient(const gdcm::DataSet& data, const std::string& text) {
  const auto letters = [](std::string from) {
    std::ranges::transform(from, from.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return from;
  };
  const std::string searched = letters(text);
  for (const gdcm::Tag& tag : {gdcm::Tag(0x0010, 0x0010), gdcm::Tag(0x0010, 0x0020), gdcm::Tag(0x0010, 0x0030),
                               gdcm::Tag(0x0010, 0x1000), gdcm::Tag(0x0010, 0x1001)}) {
    const std::string value = letters(text_of(data, tag)) + "^";
    std::string word;
    for (const char c : value) {
      if (std::string_view("^ =,\\").find(c) == std::string_view::npos) {
        word += c;
        continue;
      }
      if (word.size() >= 3 && searched.find(word) != std::string::npos) return true;
      word.clear();
    }
  }
  return false;
}

// Texts for the user, without the patient's data.
void read_names(const gdcm::DataSet& data, const std::string& character_set, Object& object) {
  const auto text = [&](std::uint16_t group, std::uint16_t element) {
    std::string found = text_of(data, gdcm::Tag(group, element), character_set);
    return names_patient(data, found) ? std::string() : found;
  };
  object.series_number = text(0x0020, 0x0011);
  object.description = text(0x0008, 0x103e);
  if (object.description.empty()) object.description = text(0x0018, 0x1030);  // the protocol's name
  object.modality = text(0x0008, 0x0060);
  object.device = text(0x0008, 0x0070);
  if (const std::string model = text(0x0008, 0x1090); !model.empty()) {
    object.device += (object.device.empty() ? "" : " ") + model;
  }
}

bool may_have_pixels(const gdcm::File& file, const std::string& class_uid, const Pixels& pixels) {
  gdcm::MediaStorage storage;
  if (!storage.SetFromHeader(file.GetHeader())) storage.SetFromDataSet(file.GetDataSet());
  return gdcm::MediaStorage::IsImage(gdcm::MediaStorage::GetMSType(class_uid.c_str())) ||
         gdcm::MediaStorage::IsImage(storage) || (pixels.rows > 0 && pixels.columns > 0);
}

}  // namespace

std::shared_ptr<const Object> read_object(const std::string& path, const isoextract_plugin_host& host) {
  auto object = std::make_shared<Object>();
  Pixels& pixels = object->pixels;
  pixels.path = path;
  auto reader = std::make_unique<gdcm::Reader>();
  auto stream = std::make_unique<std::ifstream>();
  bool found = read_up_to(*reader, *stream, path, kPixels, pixels);
  const auto data = [&]() -> const gdcm::DataSet& { return reader->GetFile().GetDataSet(); };
  object->class_uid = text_of(data(), gdcm::Tag(0x0008, 0x0016));
  if (object->class_uid.empty()) object->class_uid = text_of(reader->GetFile().GetHeader(), gdcm::Tag(0x0002, 0x0002));
  if (object->class_uid.empty() && !found)
    throw ReadError("expected the class of a DICOM object (SOP Class UID), found none: the header is damaged or cut");
  for (const gdcm::Tag& tag : {kFloatPixels, kDoublePixels}) {
    if (found || object->class_uid != "1.2.840.10008.5.1.4.1.1.30") break;  // parametric maps
    reader = std::make_unique<gdcm::Reader>();
    stream = std::make_unique<std::ifstream>();
    found = read_up_to(*reader, *stream, path, tag, pixels);
    pixels.is_float = found;
  }
  read_layout(data(), pixels);
  if (pixels.transfer_syntax == "1.2.840.10008.1.2.1.99") found = inflate(path, host, pixels);
  if (!found) {
    if (may_have_pixels(reader->GetFile(), object->class_uid, pixels))
      throw ReadError("expected pixel data after the header, found none: the file is cut");
    return nullptr;
  }
  object->problem = form_problem(pixels);
  if (object->problem.empty()) check_size(pixels);

  object->instance_uid = text_of(data(), gdcm::Tag(0x0008, 0x0018));
  object->series_uid = text_of(data(), gdcm::Tag(0x0020, 0x000e));
  object->frame_of_reference = text_of(data(), gdcm::Tag(0x0020, 0x0052));
  object->instance_number = decimal_of(data(), gdcm::Tag(0x0020, 0x0013)).value_or(0);
  object->time_step = decimal_of(data(), gdcm::Tag(0x0020, 0x0110)).value_or(0);
  const std::string character_set = text_of(data(), gdcm::Tag(0x0008, 0x0005));
  read_names(data(), character_set, *object);
  if (text_of(data(), gdcm::Tag(0x0008, 0x0008)).find("MOSAIC") != std::string::npos && object->problem.empty())
    object->problem = "expected one slice per image, found a mosaic of slices in one image (Siemens)";
  if (data().FindDataElement(gdcm::Tag(0x0028, 0x3000)))
    object->note = "its table of values (Modality LUT Sequence) is not applied";
  if (pixels.photometric == "MONOCHROME1")
    object->note = "low values are bright (MONOCHROME1); the values are those of the file";
  if (pixels.photometric == "PALETTE COLOR") object->note = "values are the numbers of palette colors";
  read_segments(data(), character_set, *object);
  read_frames(data(), *object);
  return object;
}

bool has_dicom_signature(const std::string& path) {
  std::array<char, 132> start{};
  std::ifstream stream(path, std::ios::binary);
  return stream.read(start.data(), start.size()) && std::string_view(start.data() + 128, 4) == "DICM";
}

}  // namespace isoextract_dicom

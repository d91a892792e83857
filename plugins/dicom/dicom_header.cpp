// Headers of objects, read up to the pixels.
#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

#include <gdcmMediaStorage.h>

#include "dicom_dataset.hpp"
#include "dicom_patient.hpp"
#include "dicom_structure.hpp"

namespace isoextract_dicom {
namespace {

void read_layout(const gdcm::DataSet& data, Pixels& pixels) {
  pixels.rows = uint16_of(data, gdcm::Tag(0x0028, 0x0010)).value_or(0);
  pixels.columns = uint16_of(data, gdcm::Tag(0x0028, 0x0011)).value_or(0);
  const double frames = decimal_of(data, gdcm::Tag(0x0028, 0x0008)).value_or(1);
  constexpr double kMostFrames = 1 << 24;
  if (!(frames >= 1 && frames <= kMostFrames)) {
    throw ReadError("expected a number of frames from 1 to " + number_text(kMostFrames) + ", found " +
                    number_text(frames));
  }
  pixels.frames = static_cast<std::uint32_t>(frames);
  pixels.samples_per_pixel = uint16_of(data, gdcm::Tag(0x0028, 0x0002)).value_or(1);
  pixels.planar = uint16_of(data, gdcm::Tag(0x0028, 0x0006)).value_or(0) == 1;
  pixels.bits_allocated = uint16_of(data, gdcm::Tag(0x0028, 0x0100)).value_or(pixels.is_float ? 32 : 0);
  pixels.bits_stored = uint16_of(data, gdcm::Tag(0x0028, 0x0101)).value_or(pixels.bits_allocated);
  pixels.high_bit = uint16_of(data, gdcm::Tag(0x0028, 0x0102)).value_or(pixels.bits_stored - 1);
  pixels.is_signed = uint16_of(data, gdcm::Tag(0x0028, 0x0103)).value_or(0) == 1;
  pixels.photometric = text_of(data, gdcm::Tag(0x0028, 0x0004));
}

// Texts for the user, without the patient's data. Comes after read_segments().
void read_names(const gdcm::DataSet& data, const std::string& character_set, Object& object) {
  const Patient patient(data, character_set);
  const auto text = [&](std::uint16_t group, std::uint16_t element) {
    std::string found = text_of(data, gdcm::Tag(group, element), character_set);
    return patient.is_in(found) ? std::string() : found;
  };
  object.series_number = text(0x0020, 0x0011);
  object.description = text(0x0008, 0x103e);
  if (object.description.empty()) object.description = text(0x0018, 0x1030);  // the protocol's name
  object.modality = text(0x0008, 0x0060);
  object.device = text(0x0008, 0x0070);
  if (const std::string model = text(0x0008, 0x1090); !model.empty()) {
    object.device += (object.device.empty() ? "" : " ") + model;
  }
  for (Segment& segment : object.segments) {
    std::string& name = segment.label.name;
    if (name.empty() || patient.is_in(name)) name = "segment " + std::to_string(segment.number);
  }
}

bool may_have_pixels(const std::string& class_uid, const Pixels& pixels) {
  return gdcm::MediaStorage::IsImage(gdcm::MediaStorage::GetMSType(class_uid.c_str())) ||
         (pixels.rows > 0 && pixels.columns > 0);
}

}  // namespace

std::shared_ptr<const Object> read_object(const std::string& path, const isoextract_plugin_host& host) {
  const Structure structure = check_structure(path, host);
  if (structure.class_uid.empty() && structure.pixels == 0)
    throw ReadError("expected the class of a DICOM object (SOP Class UID), found none: the header is damaged or cut");
  auto object = std::make_shared<Object>();
  object->class_uid = structure.class_uid;
  Pixels& pixels = object->pixels;
  pixels.path = path;
  pixels.transfer_syntax = structure.transfer_syntax;
  pixels.offset = structure.offset;
  pixels.bytes = structure.bytes;
  pixels.encapsulated = structure.encapsulated;
  pixels.big_endian = structure.big_endian;
  pixels.is_float = structure.pixels == 0x7FE00008U || structure.pixels == 0x7FE00009U;
  pixels.inflated = structure.inflated;

  gdcm::DataSet data;
  read_attributes(structure, host, data);
  read_layout(data, pixels);
  if (structure.pixels == 0) {
    if (may_have_pixels(structure.class_uid, pixels))
      throw ReadError("expected pixel data after the header, found none: the file ends early");
    return nullptr;
  }
  object->problem = form_problem(pixels);
  if (object->problem.empty()) check_size(pixels);

  object->instance_uid = text_of(data, gdcm::Tag(0x0008, 0x0018));
  object->series_uid = text_of(data, gdcm::Tag(0x0020, 0x000e));
  object->frame_of_reference = text_of(data, gdcm::Tag(0x0020, 0x0052));
  object->instance_number = decimal_of(data, gdcm::Tag(0x0020, 0x0013)).value_or(0);
  object->time_step = decimal_of(data, gdcm::Tag(0x0020, 0x0110)).value_or(0);
  const std::string character_set = text_of(data, gdcm::Tag(0x0008, 0x0005));
  read_segments(data, character_set, *object);
  read_names(data, character_set, *object);
  if (text_of(data, gdcm::Tag(0x0008, 0x0008)).find("MOSAIC") != std::string::npos && object->problem.empty())
    object->problem = "expected one slice per image, found a mosaic of slices in one image (Siemens)";
  if (data.FindDataElement(gdcm::Tag(0x0028, 0x3000)))
    object->note = "the reader does not apply the table of values (Modality LUT Sequence)";
  if (pixels.photometric == "MONOCHROME1")
    object->note = "low values are bright (MONOCHROME1), and the reader does not invert them";
  if (pixels.photometric == "PALETTE COLOR") object->note = "the samples are indices of the palette, not colors";
  read_frames(data, *object);
  return object;
}

bool has_dicom_signature(const std::string& path) {
  std::array<char, 132> start{};
  std::ifstream stream(path, std::ios::binary);
  return stream.read(start.data(), start.size()) && std::string_view(start.data() + 128, 4) == "DICM";
}

}  // namespace isoextract_dicom

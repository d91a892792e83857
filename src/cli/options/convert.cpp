#include "cli/options/convert.hpp"

#include <fmt/ranges.h>

#include "cli/field_plan.hpp"
#include "cli/particle_file_plan.hpp"
#include "cli/picture_plan.hpp"

namespace isoextract::cli {

std::vector<Choice<OutputFormat>> output_formats() {
  std::vector<Choice<OutputFormat>> formats;
  for (const mesh_io::MeshFormatInfo& info : mesh_io::mesh_formats()) {
    formats.push_back({std::string(info.name), {info.format}});
  }
  formats.push_back({std::string(kPictureFormat), {std::nullopt, true}});
  for (const volume_io::VolumeFileFormat format : kFieldFormats) {
    formats.push_back({std::string(word_of(format)), {std::nullopt, false, format}});
  }
  for (const particle_io::ParticleFileFormat format : kParticleFileFormats) {
    formats.push_back({std::string(word_of(format)), {std::nullopt, false, std::nullopt, format}});
  }
  return formats;
}

std::string colormap_list() {
  std::vector<std::string_view> maps;
  for (const auto& word : words_of(edit::Colormap{})) maps.push_back(word.word);
  return fmt::format("{}", fmt::join(maps, ", "));
}

std::vector<Choice<DracoBits>> draco_bits() {
  std::vector<Choice<DracoBits>> bits{{"auto", DracoBits()}};
  for (std::uint64_t b = mesh_io::kMinPositionBits; b <= mesh_io::kMaxPositionBits; ++b) {
    bits.push_back({fmt::format("{}", b), b});
  }
  return bits;
}

BatchFlags::BatchFlags(OptionSet* command) : OptionSet(command, OptionGroup::frames) {}

ConvertFlags::ConvertFlags(Of command) : of_(command) {}

ConvertFlags::ConvertFlags(OptionSet& command, Of of) : OptionSet(command, OptionGroup::run), of_(of) {}

VerifyFlags::VerifyFlags() = default;

}  // namespace isoextract::cli

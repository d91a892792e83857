#include "cli/options/input.hpp"

#include <algorithm>
#include <utility>

#include <fmt/ranges.h>

#include "particle_io/particle_format.hpp"

namespace isoextract::cli {

std::vector<Choice<std::string>> input_formats() {
  std::vector<Choice<std::string>> formats;
  for (const volume_io::VolumeFormat* format : volume_io::volume_formats()) {
    const volume_io::FormatDescription& about = format->about();
    if (about.prefix.empty()) formats.push_back({about.id, about.id});
  }
  for (const particle_io::ParticleFormatDescription& about : particle_io::particle_format_descriptions()) {
    const auto is_it = [&](const Choice<std::string>& other) { return other.name == about.id; };
    if (std::ranges::none_of(formats, is_it)) formats.push_back({about.id, about.id});
  }
  return formats;
}

std::string particle_methods() {
  std::vector<std::string> methods;
  for (const points::MethodInfo& method : points::kMethods) {
    methods.push_back(
        fmt::format("{}: {}; default iso {}, cells of {} radii", method.id, method.help, method.iso, method.cell_size));
  }
  return fmt::format("{}", fmt::join(methods, ". "));
}

InputFlags::InputFlags(OptionSet& command, InputUse use)
    : OptionSet(command, OptionGroup::input), use_(std::move(use)) {}

ParticleFlags::ParticleFlags(OptionSet& command) : OptionSet(command, OptionGroup::particles) {}

}  // namespace isoextract::cli

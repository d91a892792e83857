#include "cli/options/surface.hpp"

#include <fmt/ranges.h>

#include "cli/options/placement.hpp"
#include "cli/options/run.hpp"

namespace isoextract::cli {

std::string method_help() {
  std::vector<std::string> methods;
  for (const extract::MethodInfo& method : extract::kMethods) {
    methods.push_back(fmt::format("{}: {}", method.id, method.help));
  }
  return fmt::format("{}", fmt::join(methods, ". "));
}

std::vector<Choice<convert::LengthUnit>> units() {
  std::vector<Choice<convert::LengthUnit>> choices;
  for (const convert::LengthUnit& unit : convert::length_units()) choices.push_back({std::string(unit.name), unit});
  return choices;
}

std::vector<Choice<UnitChoice>> units_of_input() {
  std::vector<Choice<UnitChoice>> choices{{std::string(convert::kFileUnit), {}}};
  for (const convert::LengthUnit& unit : convert::length_units()) choices.push_back({std::string(unit.name), {unit}});
  return choices;
}

SurfaceFlags::SurfaceFlags(OptionSet& command) : OptionSet(command, OptionGroup::surface) {}

LabelFlags::LabelFlags(OptionSet& command, Taken taken) : OptionSet(command, OptionGroup::surface), taken_(taken) {}

EditFlags::EditFlags(OptionSet& command, Taken taken) : OptionSet(command, OptionGroup::pieces), taken_(taken) {}

PlacementFlags::PlacementFlags(OptionSet& command) : OptionSet(command, OptionGroup::placement) {}

RunFlags::RunFlags(OptionSet& command, Taken taken) : OptionSet(command, OptionGroup::run), taken_(taken) {}

DeviceFlags::DeviceFlags(OptionSet& command) : OptionSet(command, OptionGroup::run) {}

}  // namespace isoextract::cli

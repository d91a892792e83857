#include "cli/options/measuring.hpp"

#include "cli/options/simulate.hpp"

namespace isoextract::cli {

std::string following_method_ids() {
  std::vector<std::string_view> ids;
  for (const extract::MethodInfo& method : extract::interpolant_methods()) ids.push_back(method.id);
  return fmt::format("{}", fmt::join(ids, ","));
}

InfoFlags::InfoFlags() = default;
BenchFlags::BenchFlags() = default;
StabilityFlags::StabilityFlags() = default;

SequenceFlags::SequenceFlags(OptionSet& command, std::string example, std::string formats, bool takes_steps)
    : OptionSet(command, OptionGroup::output),
      example_(std::move(example)),
      formats_(std::move(formats)),
      takes_steps_(takes_steps) {}

WaterFlags::WaterFlags() = default;
JetFlags::JetFlags() = default;

}  // namespace isoextract::cli

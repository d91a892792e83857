#include "cli/remedies.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace isoextract::cli {
namespace {

struct SettingWords {
  std::vector<std::string_view> options;  // with their placeholders
  std::string_view note;                  // follows the options with placeholders
};

SettingWords setting_words(Setting setting) {
  switch (setting) {
    case Setting::none: break;
    case Setting::input_format: return {{"--input-format FORMAT"}, ""};
    case Setting::grid: return {{"--grid NAME"}, ""};
    case Setting::volume: return {{"--volume K"}, ""};
    case Setting::component: return {{"--component K"}, ""};
    case Setting::raw_layout:
      return {{"--dims NX,NY,NZ", "--dtype TYPE"}, " (and --endian, --skip, --spacing where they matter)"};
    case Setting::sample_type: return {{"--dtype TYPE"}, ""};
    case Setting::skipped_bytes: return {{"--skip BYTES"}, ""};
    case Setting::axis_order: return {{"--axis-order ORDER"}, ""};
    case Setting::level: return {{"--level K"}, ""};
    case Setting::even_spacing: return {{"--resample"}, " to make evenly spaced samples of them"};
    case Setting::spacing_and_origin: return {{"--spacing SX,SY,SZ", "--origin X,Y,Z"}, " to place the volume"};
    case Setting::frames: return {{"--frames A-B"}, " to say which"};
    case Setting::in_process: return {{"--in-process"}, " if you trust the file"};
    case Setting::attribute: return {{"--attribute NAME"}, ""};
    case Setting::attribute_volume: return {{":volume=K"}, " behind NAME=FILE"};
    case Setting::attribute_component: return {{":component=K"}, " behind NAME=FILE"};
    case Setting::attribute_spacing_and_origin:
      return {{":spacing=SX,SY,SZ", ":origin=X,Y,Z"}, " behind NAME=FILE to place the volume"};
    case Setting::volume_options:
      return {{"--grid", "--component", "--dims", "--dtype", "--endian", "--skip", "--axis-order", "--nodata",
               "--spacing", "--origin", "--inside"},
              ""};
    case Setting::particle_options: return {{"the options of particles ('isoextract help particles')"}, ""};
    case Setting::particle_method:
      return {{"--particles METHOD"}, ", such as --particles sph, to read each row of the array as a particle"};
    case Setting::radius: return {{"--radius R"}, ", in the units of the file"};
    case Setting::simulation_box: return {{"--box X0,Y0,Z0,X1,Y1,Z1"}, ""};
    case Setting::periodic_edges: return {{"--periodic x,y,z"}, ""};
    case Setting::columns: return {{"--columns x=A,y=B,z=C"}, ""};
    case Setting::selection: return {{"--select CONDITION"}, ""};
    case Setting::unwrapping: return {{"--unwrap"}, ""};
    case Setting::cell_size: return {{"--cell-size C"}, ""};
    case Setting::demo_fields: return {{"'isoextract help demo'"}, " for the demo fields and their keys"};
    case Setting::iso: return {{"--iso V"}, ""};
    case Setting::region: return {{"--roi X0,Y0,Z0,X1,Y1,Z1"}, ""};
    case Setting::parts: return {{"--roi X0,Y0,Z0,X1,Y1,Z1"}, " to extract the volume in parts"};
    case Setting::clip: return {{"--clip NX,NY,NZ,D"}, ""};
    case Setting::cuts: return {{"--clip NX,NY,NZ,D", "--roi X0,Y0,Z0,X1,Y1,Z1"}, ""};
    case Setting::labels: return {{"--labels L,..."}, ""};
    case Setting::resampling: return {{"--resolution NX,NY,NZ", "--voxel-size SX,SY,SZ"}, ""};
    case Setting::cap: return {{"--cap"}, ", which closes the surface at the faces of the volume"};
    case Setting::repair: return {{"--repair"}, ", which welds, orients, removes duplicates and fills holes"};
    case Setting::hole_edges: return {{"--repair EDGES"}, ", to fill longer holes"};
    case Setting::smoothing: return {{"--smooth N"}, ""};
    case Setting::hollow: return {{"--hollow THICKNESS"}, ""};
    case Setting::fewer_bodies: return {{"--largest N", "--drop-components MIN"}, " to keep fewer bodies"};
    case Setting::split_bodies: return {{"--split-components"}, ""};
    case Setting::nan_policy: return {{"--nan POLICY"}, ""};
    case Setting::empty_policy: return {{"--empty skip", "--empty write"}, " if an empty surface is no error"};
    case Setting::level_set_filter: return {{"--filter FILTER"}, ""};
    case Setting::blur: return {{"--blur SIGMA"}, ", which is for all fields"};
    case Setting::height_field: return {{"--heightfield"}, ", if the samples are heights of terrain"};
    case Setting::height_base: return {{"--base H"}, ""};
    case Setting::resolutions: return {{"--sizes (demo fields)", "--coarser (files)"}, ""};
    case Setting::mesh_format: return {{"--format FORMAT"}, ""};
    case Setting::half_floats: return {{"--half"}, ""};
    case Setting::output_name: return {{"name after -o"}, ""};
    case Setting::animation: return {{"--animate"}, " to write all frames into one .glb"};
    case Setting::frame_rate: return {{"--fps N"}, ""};
    case Setting::masks: return {{"--masks"}, " if each file is a mask of one object, on one grid"};
    case Setting::unit: return {{"--unit UNIT"}, ", for example --unit mm"};
    case Setting::scale: return {{"--spacing", "--scale", "--unit", "--to-unit", "--space"}, ""};
    case Setting::position:
      return {{"--center", "--origin X,Y,Z", "--space index"}, " to place the volume nearer to the origin"};
    case Setting::memory_limit: return {{"--memory-limit SIZE"}, " if the machine has the memory"};
    case Setting::cpu_backend: return {{"--backend cpu"}, ", which needs no GPU"};
    case Setting::gpu_memory: return {{"--gpu-memory SIZE"}, ""};
    case Setting::device: return {{"--device N"}, ""};
    case Setting::devices: return {{"'isoextract devices'"}, ""};
  }
  return {};
}

// One list for the process, which runs one command.
std::optional<std::vector<std::string>>& known_options() {
  static std::optional<std::vector<std::string>> names;
  return names;
}

// Returns "--grid" for "--grid NAME", ":volume=" for ":volume=K".
std::string_view name_of(std::string_view option) {
  if (option.starts_with(':')) return option.substr(0, option.find('=') + 1);
  return option.starts_with("--") ? option.substr(0, option.find(' ')) : option;
}

bool is_unknown_option(std::string_view option) {
  return known_options() && option.starts_with("--") &&
         std::ranges::find(*known_options(), name_of(option)) == known_options()->end();
}

std::string listed(std::vector<std::string_view> options, std::string_view last_word) {
  const std::string_view last = options.back();
  options.pop_back();
  return options.empty() ? std::string(last) : fmt::format("{} {} {}", fmt::join(options, ", "), last_word, last);
}

std::string step_words(const Step& step) {
  const std::string& text = step.text;
  if (step.remedy == Remedy::say) return text;
  auto [options, note] = setting_words(step.setting);
  std::erase_if(options, is_unknown_option);
  if (options.empty()) return "";
  const std::string_view name = name_of(options.front());
  const std::string_view value = options.front().substr(options.front().find_last_of(" =") + 1);
  const std::string named = fmt::format("{}{}{}", name, name.ends_with('=') ? "" : " ", text);
  const std::string one = listed(options, "or").append(note);
  const std::string all = listed(options, "and");
  const std::string choice = text.starts_with('\n') ? text : fmt::format(", {} {}", value, text);
  const std::string reason = text.empty() ? "" : ": " + text;
  switch (step.remedy) {
    case Remedy::say: break;
    case Remedy::raise: return "give a larger " + one;
    case Remedy::lower: return "give a smaller " + one;
    case Remedy::give: return fmt::format("give {}{}{}", all, note, reason);
    case Remedy::choose: return fmt::format("choose one of them with {}{}", one, text.empty() ? "" : choice);
    case Remedy::change: return fmt::format("choose another {}{}{}", one, text.empty() ? "" : " ", text);
    case Remedy::leave_out:
      std::ranges::transform(options, options.begin(), name_of);
      return options.size() == 1 ? fmt::format("leave {} out{}", options.front(), reason)
                                 : fmt::format("leave out {}{}", listed(options, "and"), reason);
    case Remedy::use: return "use " + one;
    case Remedy::set: return "use " + named;
    case Remedy::try_value: return "try " + named;
    case Remedy::check: return fmt::format("check {}{}", all, reason);
    case Remedy::see: return "see " + one;
    case Remedy::report: return "please report it and include the output of " + one;
  }
  return "";
}

}  // namespace

void set_options_of_hints(std::vector<std::string> names) { known_options() = std::move(names); }

std::string hint_text(const Hint& hint) {
  std::string text;
  for (const Step& step : hint.steps) {
    const std::string words = step_words(step);
    if (words.empty()) continue;
    if (!text.empty()) text += text.ends_with('?') ? " If not, " : "; ";
    text += words;
  }
  return text;
}

}  // namespace isoextract::cli

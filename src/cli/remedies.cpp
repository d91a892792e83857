#include "cli/remedies.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace isoextract::cli {
namespace {

// Rooms below name no options: in the text of their hints, "{component N}" stands for "--component N".
std::string with_options(std::string text) {
  for (const std::string_view name : {"component", "axis-order", "nan"}) {
    const std::string mark = fmt::format("{{{}", name);
    for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at)) {
      const std::size_t end = text.find('}', at);
      if (end == std::string::npos) break;
      text.erase(end, 1);
      text.replace(at, 1, "--");
    }
  }
  return text;
}

// Of the process, which runs one command.
std::optional<std::vector<std::string>>& known_options() {
  static std::optional<std::vector<std::string>> names;
  return names;
}

// Whole command lines are of the command that they name.
bool can_be_done(std::string_view part) {
  if (!known_options() || part.find("isoextract ") != std::string_view::npos) return true;
  for (std::size_t at = part.find("--"); at != std::string_view::npos; at = part.find("--", at + 2)) {
    const std::size_t end = part.find_first_not_of("-abcdefghijklmnopqrstuvwxyz0123456789", at);
    const std::string_view name = part.substr(at, end == std::string_view::npos ? end : end - at);
    if (name.size() > 2 && std::ranges::find(*known_options(), name) == known_options()->end()) return false;
  }
  return true;
}

std::string all_words_of(const Hint& hint) {
  const std::string& text = hint.text;
  switch (hint.remedy) {
    case Remedy::none: break;
    case Remedy::raise_memory_limit: return "raise it with --memory-limit SIZE if the machine has the memory";
    case Remedy::extract_part: return (text.empty() ? "" : text + ", or ") + "extract it in parts with --roi";
    case Remedy::widen_region: return "give --roi a larger box, or leave it out";
    case Remedy::choose_grid: return "choose one of them with --grid NAME" + text;
    case Remedy::choose_grid_number: return "choose one of them with --grid NAME[k]" + text;
    case Remedy::leave_out_grid: return "leave --grid out: there is one volume in the file";
    case Remedy::choose_volume: return "choose one of them with --volume K, K " + with_options(text);
    case Remedy::leave_out_volume: return "leave --volume out: there is one volume in the file";
    case Remedy::describe_raw:
      return "give --dims X,Y,Z and --dtype TYPE (and --endian, --skip, --spacing where they matter)";
    case Remedy::check_raw: return "check --dims, --dtype and --skip";
    case Remedy::retype_raw: return fmt::format("the size would fit --dtype {}", text);
    case Remedy::skip_in_raw:
      return fmt::format("the size would fit --skip {}, if that many bytes of header come first", text);
    case Remedy::read_as_raw: return "--input-format raw reads the bytes of any file";
    case Remedy::place_by_hand: return "place the volume with --spacing X,Y,Z and --origin X,Y,Z";
    case Remedy::rescale: return "choose another --spacing, --scale or --unit, or --space index";
    case Remedy::place_nearer:
      return (text.empty() ? "" : fmt::format("use --format {}; or ", text)) +
             "place the volume nearer with --center, --origin X,Y,Z or --space index";
    case Remedy::choose_nan_policy:
      return "use --nan outside to take them as outside, or --nan hole to leave the surface open around them";
    case Remedy::use_cpu: return text.empty() ? "--backend cpu needs no GPU" : text + "; --backend cpu needs no GPU";
    case Remedy::less_gpu_memory: return "give the GPU less at a time with --gpu-memory, or use --backend cpu";
    case Remedy::more_gpu_memory: return "give the GPU more with --gpu-memory, or use --backend cpu";
    case Remedy::other_gpu: return "'isoextract devices' tells more; leave out --device to let one be chosen";
    case Remedy::choose_mesh_format: return fmt::format("use --format {}", text);
    case Remedy::ascii_formats: return fmt::format("--ascii is for {}", text);
    case Remedy::one_file_per_surface:
      return fmt::format("use --format {}, or put {{iso}} into the name after -o to get a file for each iso value",
                         text);
    case Remedy::region_is_in_voxels: return "--roi is in voxel coordinates because of --space index";
    case Remedy::region_is_in_world:
      return "--roi is in the input's world coordinates, before --up, --scale, --unit, --to-space and --center";
    case Remedy::name_unit: return "name it with --unit, for example --unit mm";
    case Remedy::choose_scale: return "choose another --scale, --unit or --to-unit";
    case Remedy::other_output_name: return "choose another name with -o";
    case Remedy::move_cut:
      return "--clip NX,NY,NZ,D keeps where NX x + NY y + NZ z >= D: move the plane, or turn its normal round; --empty "
             "skip makes this no error";
    case Remedy::widen_region_or_skip: return "widen the --roi; --empty skip makes this no error";
    case Remedy::try_iso: return fmt::format("try --iso {}; --empty skip makes this no error", text);
    case Remedy::other_iso: return fmt::format("try --iso {}", text);
    case Remedy::leave_out_coarsest:
      return "leave out the coarsest with --sizes (demo fields) or --coarser (files), or choose another --iso";
    case Remedy::no_surface_or_skip:
      return "try another input: this one has no surface worth suggesting; --empty skip makes this no error";
    case Remedy::allow_empty: return "--empty skip makes this no error, --empty write writes a mesh without triangles";
    case Remedy::list_demo_fields: return "isoextract help demo lists the demo fields and their keys";
    case Remedy::list_gpus: return "'isoextract devices' lists them";
    case Remedy::name_frames: return "say which with --frames A-B";
    case Remedy::number_outputs:
      return "put what tells them apart into the name after -o: {frame:04} or {}, {stem}, {grid}, {iso}; or write "
             "all frames into one .glb with --animate";
    case Remedy::report_gpu: return "please report it with 'isoextract devices'; --backend cpu needs no GPU";
    case Remedy::read_as_particles:
      return "a height field is no volume; --particles METHOD takes the rows of an array for particles, such as "
             "--particles sph";
    case Remedy::leave_out_particles:
      return "leave out the options of particles: 'isoextract help particles' lists them";
    case Remedy::leave_out_volumes:
      return "leave out --grid, --component, --dims, --dtype, --endian, --skip, --axis-order, --nodata, --spacing, "
             "--origin "
             "and --inside";
    case Remedy::choose_frame:
      return "choose one of them with --volume K, or take each of them with --volume all, which goes with one file";
    case Remedy::choose_radius: return "give --radius R, in the units of the file" + text;
    case Remedy::skip_particles: return "use --nan outside to leave such particles out";
    case Remedy::fewer_attributes: return "leave --attribute out for it";
    case Remedy::smaller_cells: return "give a smaller --cell-size or, if it is not theirs, a larger --radius";
    case Remedy::leave_out_filters:
      return "leave --filter out: it is for level sets of VDB files, and of --particles spheres and smooth; --blur is "
             "for all";
    case Remedy::store_floats: return "leave --half out";
    case Remedy::read_in_process: return "if you trust the file, read it with --in-process";
  }
  return with_options(text);
}

}  // namespace

void set_options_of_hints(std::vector<std::string> names) { known_options() = std::move(names); }

std::string words_of(const Hint& hint) {
  const std::string words = all_words_of(hint);
  // Words without a code are of the command itself.
  if (hint.remedy == Remedy::none || can_be_done(words)) return words;
  constexpr std::string_view kBetween = "; ";
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= words.size();) {
    const std::size_t end = std::min(words.find(kBetween, begin), words.size());
    std::string part = words.substr(begin, end - begin);
    if (can_be_done(part)) parts.push_back(std::move(part));
    begin = end + kBetween.size();
  }
  return fmt::format("{}", fmt::join(parts, kBetween));
}

}  // namespace isoextract::cli

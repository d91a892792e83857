#include "cli/help_topics.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/ascii.hpp"
#include "base/version.hpp"
#include "cli/field_plan.hpp"
#include "field/demo_field.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "particle_io/particle_format.hpp"

namespace isoextract::cli {
namespace {

constexpr std::array kExamples{
    Example{"isoextract smoke.vdb --iso 0.5 -o smoke.glb", "a density",
            "Converts a density to a glTF file for Blender or a browser."},
    Example{"isoextract info head.nii.gz", "range, iso values",
            "Shows size, placement and range of a scan, and suggests iso values."},
    Example{"isoextract head.nii.gz --iso 60 --cap -o head.stl", "a closed scan",
            "Converts a scan to a closed mesh in the scanner's coordinates."},
    Example{"isoextract sim_*.vdb --iso 0.5 -o 'out/{stem}.glb' --mkdir", "a sequence",
            "Converts a sequence to one mesh file a frame."},
    Example{"isoextract dam.bgeo --radius 0.025 --up y -o dam.glb", "particles",
            "Extracts the surface around the particles of a fluid."},
    Example{"isoextract fluid.vdb --grid density --iso 0.2 --iso 0.6 -o fluid.glb", "",
            "Extracts two surfaces of one grid into one file."},
    Example{"isoextract head.raw --dims 48,62,42 --spacing 4 --iso 60 -o head.ply", "",
            "Reads a file without a header."},
    Example{"isoextract 'sim_{:04}.vdb' --iso 0.5 -o sim.glb --animate", "",
            "Converts a sequence to one file that plays."},
    Example{"isoextract dam.bgeo --particles smooth --radius 0.025 -o dam.vdb", "",
            "Writes the level set around particles for other programs."},
    Example{"isoextract verify smoke.vdb --iso 0.5 smoke.glb", "",
            "Checks that a mesh is the surface of its volume, triangle by triangle."},
    Example{"isoextract compare a.glb b.ply --max-distance 0.1", "",
            "Checks that two meshes are at most 0.1 apart (exit code 6 if not)."},
    Example{"isoextract check head.stl --require printable", "",
            "Lists the defects of a mesh (exit code 6 if a slicer would fail)."},
    Example{"isoextract render smoke.vdb mesh.glb -o smoke.png", "", "Draws a volume with a mesh in it."},
    Example{"isoextract 'demo:gyroid?size=128' --iso 0 --format ply -o - > gyroid.ply", "",
            "Needs no input file, and writes to stdout."},
};

HelpTopic formats_topic() {
  HelpTopic topic{"formats", "Formats", "What can be read and written.", {}};
  HelpBlock read{
      "Volumes that can be read. The format is found by the content of the file, then by its extension; "
      "--input-format overrides both.",
      {}};
  for (const volume_io::VolumeFormat* format : volume_io::volume_formats()) {
    const volume_io::FormatDescription& about = format->about();
    std::string text = about.title;
    if (about.needs_layout) text += ", with --dims and --dtype";
    if (!about.extensions.empty()) text += fmt::format(" ({})", fmt::join(about.extensions, " "));
    read.rows.push_back({about.id, text});
  }
  HelpBlock particles{
      "Particles that can be read. They become a field, as 'isoextract help particles' says, and that a surface.", {}};
  for (const particle_io::ParticleFormatDescription& about : particle_io::particle_format_descriptions()) {
    std::string text = about.title;
    if (about.has_frames) text += "; a file may hold several frames";
    particles.rows.push_back({about.id, fmt::format("{} ({})", text, fmt::join(about.extensions, " "))});
  }
  HelpBlock written{"Meshes that can be written. The format is chosen by the extension of the output, or by --format.",
                    {}};
  for (const mesh_io::MeshFormatInfo& info : mesh_io::mesh_formats()) {
    std::string text(info.title);
    text += info.can_hold_several_meshes ? "; several surfaces a file" : "; one surface a file";
    if (!info.can_stream) text += "; not to stdout";
    written.rows.push_back({std::string(info.name), text});
  }
  HelpBlock field{
      "In place of a mesh the field itself can be written, as volumes are read or particles make it, resampled and "
      "filtered. It needs no iso value.",
      {{std::string(kFieldFormat), "OpenVDB, one grid of floats, or with --half of 16-bit ones"}}};
  topic.blocks = {std::move(read), std::move(particles), std::move(written), std::move(field)};
  return topic;
}

HelpTopic demo_topic() {
  HelpTopic topic{"demo", "Demo fields", "Inputs that need no file.", {}};
  HelpBlock block{
      "demo:NAME is an input like any other, computed from a formula on the cube from -1 to 1. "
      "demo:NAME?size=N has N samples along each axis (2 to 2048, default 64); quote it, as in "
      "'demo:torus?size=200', for a shell may take the question mark for a pattern. Inside is above the iso value. "
      "Some move: demo:NAME?size=N&time=T shows them at the time T. They come back to where they were after a time of "
      "1, "
      "so that 'demo:metaballs?time=0.125' is an eighth of the way. --error measures a field that has moved against "
      "its samples alone, not against the formula.",
      {}};
  for (const field::DemoDescription& demo : field::demo_fields()) {
    block.rows.push_back(
        {fmt::format("demo:{}", demo.name), fmt::format("{} (iso {}){}{}", demo.formula, demo.iso,
                                                        demo.motion.empty() ? "" : "; with time: ", demo.motion)});
  }
  topic.blocks = {std::move(block)};
  return topic;
}

HelpTopic coordinates_topic() {
  return {
      "coordinates",
      "Coordinates",
      "Where the mesh is, and what --up, --scale, --unit and --center do.",
      {{"By default the mesh stands where the input says: each sample has its place in the input's world, by the "
        "transform, spacing, axes and origin of the file, and the mesh uses that world. --spacing and --origin "
        "replace what the file says.",
        {}},
       {"Only for glb and gltf, whose standard prescribes that y points up, the world is turned: with --up z, "
        "the default, (x, y, z) becomes (x, z, -y). With --up y the input's axes are kept. ply, obj, stl and drc "
        "prescribe nothing, and keep the input's axes. --up-out turns any of them.",
        {}},
       {"--scale multiplies the coordinates. --unit names the unit of the input's world: glb and gltf are then "
        "written in metres, other formats in that unit, and all in that of --to-unit; without it coordinates are "
        "written as they are, whatever their unit. --unit file is the unit that the file states; 'isoextract info' "
        "shows it.",
        {}},
       {"--to-space ras or lps mirrors x and y of a scan whose file says which of the two its world is, as NIfTI "
        "always does and NRRD may.",
        {}},
       {"--center moves the middle of the samples to the origin, last of all: of the whole volume or of --roi.", {}},
       {"The file says what of this was asked for; binary stl does so in its header, as far as 80 bytes reach, and stl "
        "as text does not. compare undoes it where two meshes were placed otherwise, and glTF's turn as well; of a "
        "glTF file of another program its --up says what was up.",
        {}},
       {"--space index ignores all of this and gives voxel coordinates: the first sample is at (0, 0, 0), its "
        "neighbours at distance 1. With --resolution these are the input's voxels as well, so that the mesh lies "
        "where it lies without.",
        {}},
       {"--roi is a box in the input's world, before --up, --scale and --unit, or in voxel coordinates with "
        "--space index. The triangles are cut at its faces, so that the surface ends there exactly, also where the "
        "samples' axes are oblique to the world's. --roi-snap cuts nothing and ends the surface at the outermost "
        "samples in the box, as labels and --method voxels always do.",
        {}}}};
}

HelpTopic exit_codes_topic() {
  return {"exit-codes",
          "Exit codes",
          "What the exit code says.",
          {{"Data goes to stdout, everything else to stderr. No partial file is ever left behind.",
            {{"0", "done"},
             {"1", "usage: the options or their combination make no sense"},
             {"2", "the input cannot be read, or does not hold what was asked for"},
             {"3", "a feature or device that was asked for, or a thread, is not available"},
             {"4", "the result cannot be written"},
             {"5", "some frames of a batch failed, or were not started; the others are done"},
             {"6", "what was to be verified does not hold"}}}}};
}

// Those that options of the default command are in: each is a topic.
std::vector<Word<OptionGroup>> topic_groups(const Command& program) {
  std::vector<Word<OptionGroup>> groups;
  for (const Word<OptionGroup>& group : words_of(OptionGroup{})) {
    if (!default_command(program).options().in_group(group.value).empty()) groups.push_back(group);
  }
  return groups;
}

std::string examples_text() {
  std::string out = "Examples:\n";
  for (const Example& example : examples()) out += fmt::format("  {}\n      {}\n", example.command, example.text);
  return out;
}

// Those with a short text, a line each.
std::string first_examples_text() {
  std::string out = "Examples:\n";
  for (const Example& example : examples()) {
    if (!example.brief.empty()) out += fmt::format("  {:<58} # {}\n", example.command, example.brief);
  }
  return out;
}

HelpRow summary_of(const Option& option) { return {option.spelling(), first_sentence(option.row().help)}; }

HelpBlock everyday_block(const Command& command) {
  HelpBlock block;
  for (const Option* option : command.options().options()) {
    if (option->row().everyday) block.rows.push_back(summary_of(*option));
  }
  return block;
}

std::string help_of_group(const Command& program, const Word<OptionGroup>& group) {
  const Command& command = default_command(program);
  std::string out =
      fmt::format("{} options of {}:\n{}", group.word, command.name(), plain_text(group_block(command, group.value)));
  if (group.value == OptionGroup::placement) {
    for (const HelpBlock& block : coordinates_topic().blocks) out += "\n" + plain_text(block);
  }
  return out;
}

}  // namespace

std::vector<HelpTopic> help_topics() {
  return {formats_topic(), demo_topic(), coordinates_topic(), exit_codes_topic()};
}

std::span<const Example> examples() { return kExamples; }

HelpBlock group_block(const Command& command, OptionGroup group) {
  HelpBlock block;
  for (const Option* option : command.options().in_group(group)) {
    block.rows.push_back({option->spelling(), option->row().help});
  }
  return block;
}

std::vector<std::string> help_names(const Command& program) {
  std::vector<std::string> names = program.inner_names();
  for (const Word<OptionGroup>& group : topic_groups(program)) names.push_back(to_lower(group.word));
  for (const HelpTopic& topic : help_topics()) names.emplace_back(topic.name);
  names.emplace_back(kExamplesTopic);
  return names;
}

std::string help_overview(const Command& program) {
  const Command& command = default_command(program);
  HelpBlock commands;
  for (const auto& inner : program.inner()) commands.rows.push_back({inner->name(), inner->summary()});
  std::vector<std::string> topics;
  for (const std::string& name : help_names(program)) {
    if (program.find(name) == nullptr) topics.push_back(name);
  }
  return fmt::format("{} {}\nUsage: {}\n\n", generator(), program.summary(), command.synopsis()) +
         "Options that most runs need:\n" + plain_text(everyday_block(command)) + "\n" + first_examples_text() +
         "\nCommands:\n" + plain_text(commands) +
         "\nMore: isoextract COMMAND --help | --help-all | --version | help TOPIC\n" +
         plain_text({fmt::format("Topics: {}", fmt::join(topics, " ")), {}});
}

std::string help_of_command(const Command& command, HelpDetail detail) {
  std::string out = fmt::format("{}\n\nUsage: {}\n", command.summary(), command.synopsis());
  HelpBlock inner;
  for (const auto& of_it : command.inner()) inner.rows.push_back({of_it->full_name(), of_it->summary()});
  if (!inner.rows.empty()) {
    out += fmt::format("\nCommands ('isoextract {} COMMAND --help' lists their options):\n{}", command.full_name(),
                       plain_text(inner));
  }
  for (const Word<OptionGroup>& group : words_of(OptionGroup{})) {
    HelpBlock block = group_block(command, group.value);
    if (detail == HelpDetail::summaries) {
      for (HelpRow& row : block.rows) row.text = first_sentence(row.text);
    }
    if (!block.rows.empty()) out += fmt::format("\n{}:\n{}", group.word, plain_text(block));
  }
  return command.is_default() && detail == HelpDetail::all ? out + "\n" + examples_text() : out;
}

std::string help_of(const Command& program, std::string_view name) {
  if (const Command* command = program.find(name)) return help_of_command(*command, HelpDetail::summaries);
  if (name == kExamplesTopic) return examples_text();
  for (const Word<OptionGroup>& group : topic_groups(program)) {
    if (to_lower(group.word) == name) return help_of_group(program, group);
  }
  std::string out;
  for (const HelpTopic& topic : help_topics()) {
    if (topic.name != name) continue;
    for (const HelpBlock& block : topic.blocks) out += (out.empty() ? "" : "\n") + plain_text(block);
  }
  return out;
}

std::string short_usage(const Command& program) {
  std::string out;
  const char* before = "usage: ";
  for (const auto& command : program.inner()) {
    out += before + command->synopsis() + "\n";
    before = "       ";
  }
  return out + "Try: isoextract demo:gyroid --iso 0 -o gyroid.glb   or: isoextract help\n";
}

}  // namespace isoextract::cli

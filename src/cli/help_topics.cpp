#include "cli/help_topics.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/ascii.hpp"
#include "base/version.hpp"
#include "cli/field_plan.hpp"
#include "cli/note_guide.hpp"
#include "field/demo_field.hpp"

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
    Example{"isoextract scan.stl --repair --triangles 50k -o small.stl", "", "Repairs and simplifies a mesh file."},
    Example{"isoextract render smoke.vdb mesh.glb -o smoke.png", "", "Draws a volume with a mesh in it."},
    Example{"isoextract 'demo:gyroid?size=128' --iso 0 --format ply -o - > gyroid.ply", "",
            "Needs no input file, and writes to stdout."},
};

HelpTopic demo_topic() {
  HelpTopic topic{"demo", "Demo fields", "Inputs that need no file.", {}};
  HelpBlock block{
      "demo:NAME is an input without a file: a formula on the cube from -1 to 1. demo:NAME?size=N has N samples along "
      "each axis (2 to 2048, default 64). Quote it for the shell, as in 'demo:torus?size=200'. Inside is above the iso "
      "value. Some fields move: demo:NAME?size=N&time=T is the field at time T, and T = 1 equals T = 0. For times "
      "other than 0, --error compares with the samples only, not with the formula.",
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
  return {"coordinates",
          "Coordinates",
          "Where the mesh lies, and what --up, --scale, --unit and --center do.",
          {{"By default the mesh lies in the input's world coordinates: the transform, spacing, axes and origin of the "
            "file place each sample there. --spacing and --origin replace those of the file.",
            {}},
           {"glb and gltf prescribe that y points up, so isoextract rotates the mesh for them: with --up z, the "
            "default, (x, y, z) becomes (x, z, -y); with --up y the axes stay. ply, obj, stl and drc prescribe no up "
            "axis and keep the axes of the input. --up-out z|y rotates the mesh for any format.",
            {}},
           {"--scale multiplies the coordinates. --unit names the unit of the input's world: isoextract then writes "
            "glb and gltf in meters, other formats in that unit, and any format in the unit of --to-unit. Without "
            "--unit and --scale it writes the coordinates as they are. --unit file takes the unit that the file "
            "states; 'isoextract info' shows it.",
            {}},
           {"--to-space ras or lps moves a scan into that patient space: it negates x, y or both where the space of "
            "the file differs. The file must state its space: NIfTI and DICOM always do, NRRD may.",
            {}},
           {"--center comes last and moves the center of the samples, or of --roi, to the origin.", {}},
           {"Mesh files record their placement, except stl as text, and binary stl if its header of 80 bytes is too "
            "short. compare transforms meshes with different placements back to the world of their input. If only one "
            "mesh is glTF and a record is missing, --up of compare names the up axis of the other mesh.",
            {}},
           {"--space index writes voxel coordinates: the first sample is at (0, 0, 0), its neighbors are at distance "
            "1. With --resolution these are voxels of the input. Of the options above it takes only --spacing and "
            "--origin, which then change nothing.",
            {}},
           {"--roi is a box in the input's world, before --up, --scale and --unit, or in voxel coordinates with "
            "--space index. The surface ends exactly at its faces, also where the axes of the samples are oblique. "
            "With --roi-snap it ends at samples instead, as voxels, surface nets and labels always do: at the "
            "outermost in the box, with oblique axes at those that cover the box.",
            {}}}};
}

HelpTopic labels_topic() {
  return {"labels",
          "Label maps",
          "Meshes of the labels of a segmentation.",
          {{"A label map has a whole number at each voxel: the label of the organ, cell or grain there, or 0 for none. "
            "'isoextract info' tells whether a file is one, and lists its labels with names, voxels and volumes. "
            "--labels makes a mesh of each label; neighbors share their boundary exactly.",
            {{"isoextract info seg.nii.gz", "lists the labels"},
             {"isoextract seg.nii.gz --labels all -o organs.glb", "an object for each label in one file"},
             {"isoextract seg.nii.gz --labels all --triangles 10% -o small.glb",
              "a tenth of the triangles; neighbors keep common faces"},
             {"isoextract seg.nii.gz --labels 1,4 -o 'organ_{label}.stl'", "a file for each of two labels"}}},
           {"An iso value has no meaning here: labels have no order, so the surface at an iso value joins all labels "
            "above it. --relax N sets how smooth the meshes are, --label-names FILE gives names and colors. "
            "Segmentations of 3D Slicer (.seg.nrrd) have names of their own and need no --labels.",
            {}}}};
}

HelpTopic masks_topic() {
  return {
      "masks",
      "Binary masks",
      "Meshes of a mask that has two values.",
      {{"A mask has one value inside and another outside, such as 1 and 0, or 255 and 0. Marching cubes, the default "
        "method of --iso, keep the steps of the voxels, because a mask has no values to interpolate. Surface nets "
        "(--method surface-nets) make a smooth, closed surface. They are the default method of --labels, and a mask is "
        "a label map with one label.",
        {{"isoextract mask.nii.gz --labels 1 -o mask.stl", "a smooth closed surface; --labels 255 if 255 is inside"},
         {"isoextract mask.nii.gz --iso 0.5 --method surface-nets -o mask.stl", "the same surface by an iso value"},
         {"isoextract mask.nii.gz --labels 1 --relax 100 -o smooth.stl", "smoother, and takes longer"},
         {"isoextract mask.nii.gz --labels 1 --method voxels -o steps.stl", "the voxels as they are"}}},
       {"Many masks of one grid, one file each, become the meshes of one file with --masks. Each mesh has the name of "
        "its file. Neighbors meet without gaps; masks that overlap keep all their voxels.",
        {{"isoextract segmentations --masks -o organs.glb", "all masks of the folder"},
         {"isoextract heart.nii.gz aorta.nii.gz --masks -o chest.glb", "these masks"},
         {"isoextract segmentations --masks --labels 'kidney*' -o '{name}.stl'", "some of them, a file each"},
         {"isoextract info segmentations --masks", "voxels, volume and bounds of each mask"}}}}};
}

HelpTopic mpi_topic() {
  return {"mpi",
          "MPI",
          "One run on several processes and machines, started by mpirun.",
          {{"'mpirun -n 4 isoextract ...' runs the command on 4 ranks: processes on one or more machines that see the "
            "same files. Only rank 0 prints. The exit code and the files are the same as those of one process.",
            {}},
           {"Ranks on the same processors share the threads, and ranks on one machine share its memory; --threads and "
            "--memory-limit apply to each rank. --verbose prints the time of each rank.",
            {}},
           {"Sequences: each rank converts the next frame when it is free; there is one manifest. With --animate and "
            "--html rank 0 converts all frames. One file: each rank extracts and writes a part, if the samples are "
            "dense, the method is mc or mt, and the output is a binary .ply or a .glb with one surface.",
            {}},
           {"Otherwise rank 0 works alone while the other ranks wait: with sparse samples, small meshes, --nan hole, "
            "--backend gpu, attributes, --error, --largest, or --cap together with --report. So it does with options "
            "that edit, compress or verify the mesh. A note gives the reason.",
            {}},
           {"If a rank ends early, mpirun ends all ranks. No file is then incomplete, and --resume continues a "
            "sequence. Ranks need the MPI plug-in, which the build makes if it finds MPI (libopenmpi-dev). With Slurm, "
            "use srun --mpi=pmix in place of mpirun.",
            {}}}};
}

HelpTopic exit_codes_topic() {
  return {"exit-codes",
          "Exit codes",
          "The exit codes of all commands.",
          {{"Data goes to stdout, messages to stderr. A file gets its name only when it is complete.",
            {{"0", "done"},
             {"1", "usage: the options or their combination are invalid"},
             {"2",
              "input: the program cannot read the input, has too little memory for it, or finds no surface in it; or "
              "its content does not suit an option"},
             {"3", "unavailable: a feature, a plug-in, a device or a thread is missing or fails"},
             {"4", "output: the program cannot write the result"},
             {"5", "frames: frames of a sequence failed, were not started or have no input; the others are done"},
             {"6",
              "verification: a mesh does not match or fails a requirement (verify, compare, check, stability, or a "
              "conversion with --verify or --require)"},
             {"130", "cancelled: Ctrl-C ended the program; if another signal N ends it, shells show 128 + N"}}}}};
}

HelpTopic notes_topic() {
  HelpTopic topic{"notes", "Notes", "The ids of notes, and how to hide notes.", {}};
  HelpBlock block{
      "A note describes a result that you may not expect; it changes no exit code. --no-note ID,ID,... hides the notes "
      "of these ids on the terminal.",
      {}};
  for (const NoteGuide& note : note_guide()) {
    block.rows.push_back({std::string(word_of(note.id)), note.remedy.empty()
                                                             ? std::string(note.cause)
                                                             : fmt::format("{} {}", note.cause, note.remedy)});
  }
  topic.blocks = {std::move(block)};
  return topic;
}

// Returns the option groups that the default command uses; each group is a help topic.
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

// Returns one line for each example that has a short text.
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
  return {demo_topic(), labels_topic(),     masks_topic(), coordinates_topic(),
          mpi_topic(),  exit_codes_topic(), notes_topic()};
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
         "More: isoextract COMMAND --help | --help-all | --version | help TOPIC\n" +
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

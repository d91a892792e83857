#include "cli/foreign_options.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "cli/plan_parts.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::cli {
namespace {

struct ForeignOption {
  std::string_view name;
  std::string_view ours;  // the equivalent option
  std::string_view does;  // its effect, as text after its name
};

// Names from VTK, ParaView, splashsurf, vdb_tool, gltfpack, scikit-image and medical tools.
constexpr std::array kForeignOptions{
    ForeignOption{"--threshold", "--iso", "V sets the iso value of the surface"},
    ForeignOption{"--surface-threshold", "--iso", "V sets the iso value of the surface"},
    ForeignOption{"--isovalue", "--iso", "V sets the iso value of the surface"},
    ForeignOption{"--isolevel", "--iso", "V sets the iso value of the surface"},
    ForeignOption{"--contour", "--iso", "V sets the iso value of the surface"},
    ForeignOption{
        "--decimate", "--simplify",
        "D removes triangles and keeps the surface within D voxels, --triangles N|P% keeps N triangles or P percent"},
    ForeignOption{
        "--reduce", "--simplify",
        "D removes triangles and keeps the surface within D voxels, --triangles N|P% keeps N triangles or P percent"},
    ForeignOption{"--target-reduction", "--triangles", "10% keeps a tenth of the triangles"},
    ForeignOption{"--target-count", "--triangles", "N keeps N triangles"},
    ForeignOption{"--faces", "--triangles", "N keeps N triangles"},
    ForeignOption{"--adaptivity", "--simplify", "D removes triangles and keeps the surface within D voxels"},
    ForeignOption{"--crop", "--roi", "X0,Y0,Z0,X1,Y1,Z1 extracts from that box only"},
    ForeignOption{"--bbox", "--roi", "X0,Y0,Z0,X1,Y1,Z1 extracts from that box only"},
    ForeignOption{"--extent", "--roi", "X0,Y0,Z0,X1,Y1,Z1 extracts from that box only"},
    ForeignOption{"--watertight", "--cap", "closes the surface where it leaves the data"},
    ForeignOption{"--closed", "--cap", "closes the surface where it leaves the data"},
    ForeignOption{"--flip", "--inside", "above|below sets which side of the iso value is inside"},
    ForeignOption{"--invert", "--inside", "above|below sets which side of the iso value is inside"},
    ForeignOption{"--cuda", "--backend", "gpu extracts on the GPU"},
    ForeignOption{"--gpu", "--backend", "gpu extracts on the GPU"},
    ForeignOption{"--shape", "--dims", "NX,NY,NZ sets the size of a raw file in samples"},
    ForeignOption{"--datatype", "--dtype", "is the type of a raw file's samples"},
};

}  // namespace

std::string hint_for_other_programs_option(const OptionSet& options, std::string_view name) {
  const auto* const found = std::ranges::find(kForeignOptions, name, &ForeignOption::name);
  if (found == kForeignOptions.end()) return "";
  if (options.find(found->ours) == nullptr) return "";
  return fmt::format("{} {}", found->ours, found->does);
}

Result<void> refuse_output_among_inputs(const ConvertFlags& flags) {
  const std::vector<std::string>& inputs = flags.input.inputs;
  if (flags.output || inputs.size() < 2) return {};
  const std::string& last = inputs.back();
  const auto format = mesh_io::mesh_format_by_path(last);
  if (!format) return {};
  // An existing PLY may be an input of particles, and an existing mesh beside other meshes one more input.
  std::error_code none;
  const bool may_be_input = *format == mesh_io::MeshFormat::ply || mesh_io::mesh_format_by_path(inputs.front());
  if (may_be_input && std::filesystem::exists(last, none)) return {};
  return refuse_usage(fmt::format("{}: the last input has the name of a mesh file, and -o is missing", last),
                      fmt::format("give the output with -o: -o {}", shell_quoted(last)));
}

}  // namespace isoextract::cli

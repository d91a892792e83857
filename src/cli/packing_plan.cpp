#include "cli/packing_plan.hpp"

#include <string_view>

#include <fmt/format.h>

#include "cli/plan_parts.hpp"

namespace isoextract::cli {

Result<mesh_io::PackingOptions> plan_packing(const ConvertFlags& flags, mesh_io::MeshFormat format) {
  const std::string_view name = mesh_io::mesh_format_info(format).name;
  const bool is_drc = format == mesh_io::MeshFormat::drc;
  if (format != mesh_io::MeshFormat::glb && format != mesh_io::MeshFormat::gltf) {
    const Option* const option = flags.draco && !is_drc ? static_cast<const Option*>(&flags.draco)
                                 : flags.quantize       ? &flags.quantize
                                 : flags.meshopt        ? &flags.meshopt
                                                        : nullptr;
    if (option != nullptr) {
      return refuse_usage(
          fmt::format("{} does not work with {}, which cannot pack meshes this way", option->name(), name),
          is_drc ? "drc always uses Draco; glb and gltf support this option" : "glb and gltf support this option");
    }
  }
  const bool draco = flags.draco || is_drc;
  const std::string_view by_draco = flags.draco ? std::string_view(flags.draco.name()) : "drc";
  TRY(refuse_both(flags.draco, flags.meshopt, "a file compresses a mesh once", "leave one of them out"));
  TRY(refuse_both(flags.draco, flags.quantize, "Draco itself rounds positions to the number of bits of --draco",
                  "--draco=16 keeps as many bits as --quantize"));
  if (draco && flags.optimize_order) {
    return refuse_usage(
        fmt::format("--optimize-order does not work with {}: Draco stores its own order of triangles and vertices",
                    by_draco),
        "leave --optimize-order out");
  }
  mesh_io::PackingOptions packing;
  packing.quantize = flags.quantize;
  packing.optimize_order = flags.optimize_order;
  if (draco) packing.compression = mesh_io::Compression::draco;
  if (flags.meshopt) packing.compression = mesh_io::Compression::meshopt;
  if (flags.draco) packing.position_bits = *flags.draco;
  return packing;
}

}  // namespace isoextract::cli

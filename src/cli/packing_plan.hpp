// Plans the packing of meshes (--draco, --meshopt, --quantize, --optimize-order).
#pragma once

#include "base/error.hpp"
#include "cli/options.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::cli {

// Plans --draco, --quantize, --meshopt and --optimize-order. Fails with ErrorCode::usage if `format` does not support
// an option or if two options exclude each other.
[[nodiscard]] Result<mesh_io::PackingOptions> plan_packing(const ConvertFlags& flags, mesh_io::MeshFormat format);

}  // namespace isoextract::cli

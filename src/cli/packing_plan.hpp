// How meshes are packed into their files: what the options of it make together.
#pragma once

#include "base/error.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

[[nodiscard]] Result<convert::PackingOptions> plan_packing(const ConvertFlags& flags, mesh_io::MeshFormat format);

}  // namespace isoextract::cli

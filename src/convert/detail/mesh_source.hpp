// Mesh files as the input of a conversion: reads a file, makes surfaces of its meshes, and places them.
#pragma once

#include <filesystem>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/events.hpp"
#include "convert/source.hpp"

namespace isoextract::convert {

// Reads the mesh file and places its meshes in output coordinates. If the output's format can hold several meshes, each
// mesh of the file is a surface; else the whole file is one surface, with a note about the names that are lost. A file
// without triangles gives one empty surface.
//
// Placement: positions change only as SourceOptions::placement says, exactly for turns by right angles. The placement
// record of a file of isoextract is continued (Source::from_world).
//
// Fails as mesh_io::read_mesh() and place_field() do.
[[nodiscard]] Result<Source> open_mesh_source(const SourceOptions& options, const SourceUse& use,
                                              const Context& context, Events& events);

// Returns the files of a mesh: the file itself, and the data files that a .gltf names.
[[nodiscard]] std::vector<std::filesystem::path> list_mesh_files(const std::filesystem::path& input,
                                                                 const Context& context);

}  // namespace isoextract::convert

// Opens mesh files as the input of a conversion: reads a file, places its meshes, and makes a surface of each.
#pragma once

#include <filesystem>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/events.hpp"
#include "convert/source.hpp"

namespace isoextract::convert {

// Reads the mesh file and places its meshes in output coordinates. With SourceUse::meshes_apart, each mesh of the file
// is a surface. Otherwise the whole file is one surface; if it has several meshes, a note says that their names are
// lost. A file without triangles gives one empty surface.
//
// Applies only SourceOptions::placement to the positions; turns by right angles are exact. If the file has a placement
// record of isoextract, Source::from_world combines it with the new placement.
//
// Fails as mesh_io::read_mesh() and place_field() do, and with ErrorCode::out_of_memory.
[[nodiscard]] Result<Source> open_mesh_source(const SourceOptions& options, const SourceUse& use,
                                              const Context& context, Events& events);

// Returns the input files of a mesh: the file itself, and the data files that a .gltf names.
[[nodiscard]] std::vector<std::filesystem::path> list_mesh_files(const std::filesystem::path& input,
                                                                 const Context& context);

}  // namespace isoextract::convert

// The options that say where a mesh is.
#pragma once

#include <optional>
#include <vector>

#include "cli/option.hpp"
#include "cli/values.hpp"
#include "convert/placement.hpp"

namespace isoextract::cli {

// Of the input's world: a unit, or the one that the file states.
struct UnitChoice {
  std::optional<convert::LengthUnit> unit;
};

[[nodiscard]] std::vector<Choice<convert::LengthUnit>> units();
[[nodiscard]] std::vector<Choice<UnitChoice>> units_of_input();

struct PlacementFlags : OptionSet {
  explicit PlacementFlags(OptionSet& command);

  Value<convert::Space> space{*this, "--space",
                              "Coordinates of the mesh: the input's world, or voxels counted from 0 (default: world).",
                              About::surface};
  Value<convert::UpAxis> up{
      *this, "--up",
      "The axis of the input's world that points up (default: z). glb and gltf prescribe y up, so z-up "
      "input is turned for them: (x, y, z) becomes (x, z, -y). ply, obj, stl and drc keep the input's axes.",
      About::surface | About::world};
  Value<convert::UpAxis> up_out{
      *this, "--up-out",
      "The axis of the mesh that points up (default: y in glb and gltf, that of --up in others). From y up to "
      "z up (x, y, z) becomes (x, -z, y).",
      About::surface | About::world | About::mesh_file};
  Value<convert::AnatomicalSpace> to_space{
      *this, "--to-space",
      "Mirror x and y of a scan's world as it takes: ras (right, anterior, superior, as NIfTI) or lps (left, "
      "posterior, superior, as DICOM). The file has to say which of them its world is (default: the file's).",
      About::surface | About::world};
  Value<double> scale{
      *this, "--scale", "S", parse_positive, "Multiply the world coordinates by S.", About::surface | About::world};
  Value<UnitChoice> unit{
      *this, "--unit", units_of_input(),
      "Unit of the input's world; file is the one that it states, which 'isoextract info' shows. glb and gltf are "
      "written in metres, as glTF prescribes, and other formats in that unit (default: coordinates are written as they "
      "are). Not together with --scale.",
      About::surface | About::world};
  Value<convert::LengthUnit> to_unit{*this, "--to-unit", units(),
                                     "Unit of the mesh, of any format, in place of that; needs --unit.",
                                     About::surface | About::world};
  Flag center{*this, "--center",
              "Move the middle of the samples to the origin: that of --roi where it is given. All surfaces of a volume "
              "move alike.",
              About::surface | About::world};
};

}  // namespace isoextract::cli

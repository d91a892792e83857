// The options of a mesh's placement.
#pragma once

#include <optional>
#include <vector>

#include "cli/option.hpp"
#include "cli/values.hpp"
#include "convert/placement.hpp"

namespace isoextract::cli {

// The value of --unit, the unit of the input's world; unset: the unit that the file states.
struct UnitChoice {
  std::optional<convert::LengthUnit> unit;
};

// Returns the values of --to-unit.
[[nodiscard]] std::vector<Choice<convert::LengthUnit>> units();
// Returns the values of --unit: "file", then units().
[[nodiscard]] std::vector<Choice<UnitChoice>> units_of_input();

struct PlacementFlags : OptionSet {
  explicit PlacementFlags(OptionSet& command);

  Value<convert::Space> space{*this, "--space",
                              "Coordinates of the mesh (default: world). index means voxel coordinates: the first "
                              "sample is at 0, its neighbors at 1.",
                              About::surface};
  Value<convert::UpAxis> up{
      everyday(*this), "--up",
      "Axis that points up in the input's world (default: z). glTF prescribes y up, so glb and gltf are turned from z "
      "up: (x, y, z) becomes (x, z, -y). Other formats keep the input's axes; pictures show this axis up.",
      About::surface | About::world};
  Value<convert::UpAxis> up_out{*this, "--up-out",
                                "Axis that points up in the mesh. Default: y in glb and gltf, that of --up in other "
                                "formats. From y up to z up, (x, y, z) becomes (x, -z, y).",
                                About::surface | About::world | About::mesh_file};
  Value<convert::AnatomicalSpace> to_space{
      *this, "--to-space",
      "Patient space of the mesh: ras or lps. Mirrors x and y as needed: ras is right, anterior, superior (NIfTI); lps "
      "is left, posterior, superior (DICOM). The file must state its own space, which is the default.",
      About::surface | About::world};
  Value<double> scale{everyday(*this),
                      "--scale",
                      "S",
                      parse_positive,
                      "Factor on the world coordinates.",
                      About::surface | About::world};
  Value<UnitChoice> unit{*this, "--unit", units_of_input(),
                         "Unit of the input's world. file takes the unit that the file states ('isoextract info' shows "
                         "it). glb and gltf are then written in meters, as glTF prescribes, other formats in this "
                         "unit. Without --unit coordinates are written unchanged. Not with --scale.",
                         About::surface | About::world};
  Value<convert::LengthUnit> to_unit{*this, "--to-unit", units(), "Unit of the mesh, in any format; needs --unit.",
                                     About::surface | About::world};
  Flag center{*this, "--center",
              "Move the center of the volume to the origin. With --roi, the center of that box. All surfaces of a "
              "volume move alike.",
              About::surface | About::world};
};

}  // namespace isoextract::cli

// The options of surfaces: which one is extracted, and what changes it afterwards.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "cli/option.hpp"
#include "cli/values.hpp"
#include "convert/conversion_job.hpp"
#include "extract/extractor.hpp"
#include "extract/method.hpp"
#include "field/resample.hpp"

namespace isoextract::cli {

// "Marching cubes, or marching tetrahedra with six a cell"
[[nodiscard]] std::string method_help();

// `before` and `after` are what is said of it besides.
struct IsoOption : Values<convert::IsoChoice> {
  IsoOption(const Place& place, std::string_view before, std::string_view after)
      : Values(
            place, "--iso", "V", parse_iso,
            fmt::format(
                "{}The value whose surface is extracted: a number; p99, p0.5 and so on, the percentile of the input's "
                "samples; or auto, what 'isoextract info INPUT' suggests, for particles the usual value of the "
                "method. Percentiles are of all samples that are numbers, without the background of sparse grids, "
                "whatever --roi and --resolution leave of them.{}",
                before, after),
            About::surface) {}
  using Values::operator=;
};

struct NanOption : Value<extract::NanPolicy> {
  explicit NanOption(const Place& place)
      : Value(place, "--nan",
              "What a sample that is not a number means: the end, outside, or a hole in the surface, left by the cells "
              "that touch it (default: error). With outside, particles at places that are no numbers are left out and "
              "counted.",
              About::extraction) {}
};

// What decides about a surface besides the iso value.
struct SurfaceFlags : OptionSet {
  explicit SurfaceFlags(OptionSet& command);

  Value<extract::Method> method{*this, "--method",
                                fmt::format("{} (default: {}).", method_help(), extract::method_ids()[0]),
                                About::surface | About::drawn_surface};
  Value<field::Box> roi{
      *this,
      "--roi",
      "X0,Y0,Z0,X1,Y1,Z1",
      parse_box,
      "Only the part of the surface in this box, given by its smaller and larger corner in the input's world "
      "coordinates (with --space index in voxel coordinates). Triangles are cut at faces that lie between samples, and "
      "the surface is open there, or closed with --cap. Voxels and surface nets stay whole.",
      About::surface | About::drawn_surface};
  Flag roi_snap{*this, "--roi-snap", "End the surface at the outermost samples in the --roi, and cut nothing.",
                About::surface | About::drawn_surface};
  Values<convert::ClipPlane> clip{
      *this,
      "--clip",
      "NX,NY,NZ,D",
      parse_clip_plane,
      "Keep of the surface what lies on the side of a plane that its normal N points to: NX x + NY y + NZ z >= "
      "D, in the same coordinates. Triangles are cut, and the surface is open there, or closed with --cap. Several "
      "times for several planes.",
      About::surface | About::edit};
  Value<glm::ivec3> resolution{
      *this, "--resolution", "NX,NY,NZ", parse_resolution,
      "Extract from a grid of so many samples over the same box, or one number for all axes: means of the input's "
      "samples along axes that get fewer, values between them along those that get more (default: the input's samples "
      "themselves). A sparse grid becomes dense: its active voxels and one of background around them. Of --labels the "
      "nearest samples. --space index and --roi keep the input's voxel coordinates, --error its voxels; those of "
      "--simplify are the grid's."};
  Value<glm::dvec3> voxel_size{
      *this, "--voxel-size", "SX,SY,SZ", parse_spacing,
      "In place of --resolution: the edges of that grid's voxels in units of the input's world, or one number for all, "
      "such as 0.5. They are changed as little as makes them divide the box, and a note says so."};
  Value<field::ResampleKernel> kernel{
      *this, "--kernel",
      "What is between the input's samples where that grid is finer: a line from one to the next; a smooth curve "
      "through them (Catmull-Rom); or the cubic B-spline, which is smoother and not through them (default: linear). "
      "nearest takes the nearest sample, also where that grid is coarser: no value is made that the input does not "
      "have. It is the one kernel of --labels."};
  Values<convert::FilterStep> filters{
      *this, "--filter", "gaussian|median|mean", parse_filter,
      "Smooth a level set, of a VDB file or of --particles spheres or smooth, before anything else is done with it: "
      "each value is taken from those up to 1 voxel away or, as in gaussian:3, up to 3. Several times for several "
      "filters, one after the other. Needs the plug-in around OpenVDB."};
  Values<convert::BlurStep> blurs{
      *this, "--blur", "SIGMA|median:N", parse_blur,
      "Blur the samples of any field, dense or sparse, before its surface is looked for: by a Gaussian with this "
      "standard deviation, in voxels (1.5) or the input's units (0.7world), or by the median of the samples up to N "
      "voxels away. Samples that are not numbers are left out of what is around them. Several times for several, "
      "after --filter."};
  Flag cap{*this, "--cap", "Close the surface where it leaves the data or the --roi, and where --clip cuts it.",
           About::surface | About::drawn_surface};
  NanOption nan{*this};
};

// What changes a surface after it is extracted.
struct EditFlags : OptionSet {
  explicit EditFlags(OptionSet& command);

  Value<convert::LeastPiece> least{
      *this,
      "--drop-components",
      "MIN",
      parse_least_piece,
      "Drop components of fewer triangles than MIN (100), or of less area or volume (area:40, volume:5 in voxels, "
      "volume:5world in the units of the written mesh). A body goes with the cavities in it; a cavity that goes is "
      "filled.",
      About::surface | About::edit};
  Flag fill_cavities{*this, "--fill-cavities", "Drop the walls of all cavities, and what lies loose in them.",
                     About::surface | About::edit};
  Value<std::uint64_t> largest{
      *this,
      "--largest",
      "N",
      parse_positive_count,
      "Keep the N bodies of the largest area, with the cavities in them (default: 1). --drop-components and "
      "--fill-cavities come first.",
      About::surface | About::edit,
      IfLeftOut{"1"}};
  Flag split{*this, "--split-components",
             "Write each body, with the cavities in it, as a mesh of its own, the largest first: in one file as "
             "'NAME piece 1' and so on, or with {piece} in the name after -o as a file each.",
             About::surface | About::edit};
  Value<convert::SmoothChoice> smooth{
      *this,
      "--smooth",
      "N[:taubin|sinc[:BAND]]",
      parse_smoothing,
      "Smooth the surface by N passes of Taubin's filter (the default) or of a windowed sinc, which keep its size. "
      "BAND is what passes, between 0 and 1 (default: 0.1): a smaller one smooths more. Vertices of open borders stay "
      "where they are, and those of caps in their plane. How far vertices moved, and by how much the volume changed, "
      "is told.",
      About::surface | About::edit};

  [[nodiscard]] convert::SurfaceEdits chosen() const {
    convert::SurfaceEdits edits;
    edits.pieces = {least, fill_cavities, largest, split};
    edits.smooth = smooth;
    return edits;
  }
};

}  // namespace isoextract::cli

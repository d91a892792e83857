// The options of surfaces: extraction and edits.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
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

// Returns "mc: marching cubes. mt: marching tetrahedra (six in each cell). ...", without the last full stop.
[[nodiscard]] std::string method_help();

// `before` and `after` are further parts of the help text.
struct IsoOption : Values<convert::IsoChoice> {
  IsoOption(const Place& place, std::string_view before, std::string_view after)
      : Values(
            place, "--iso", "V", parse_iso,
            fmt::format(
                "{}Iso value of the surface: a number, p99, auto or zero. p99, p0.5 and so on are percentiles of the "
                "samples, without NaN and without the background of sparse grids; --roi and --resolution do not change "
                "percentiles. "
                "auto is the value that 'isoextract info' suggests, for particles the usual value of the method. zero "
                "is the iso value of a level set's surface.{}",
                before, after),
            About::surface) {}
  using Values::operator=;
};

struct NanOption : Value<extract::NanPolicy> {
  explicit NanOption(const Place& place)
      : Value(place, "--nan",
              "What a NaN sample means (default: error). error refuses the input; outside counts the sample as "
              "outside; hole leaves the surface open around it. With --nodata the default is outside. With outside, "
              "particles at NaN positions are left out "
              "and counted.",
              About::extraction) {}
};

// The options of the extraction that convert, verify and render share, besides the iso value.
struct SurfaceFlags : OptionSet {
  explicit SurfaceFlags(OptionSet& command);

  Value<extract::Method> method{
      *this, "--method",
      fmt::format("Extraction method (default: {1}). {0}. Default with --labels: surface-nets.", method_help(),
                  extract::method_ids()[0]),
      About::surface | About::drawn_surface};
  Value<field::Box> roi{
      *this,
      "--roi",
      "X0,Y0,Z0,X1,Y1,Z1",
      parse_box,
      "Box to extract: smaller, then larger corner. In the input's world; with --space index the box is in voxel "
      "coordinates. Triangles are cut at its faces, and the surface is open there, or closed with "
      "--cap. Voxels and surface nets are not cut. Particles too far away to change the surface in the box are left "
      "out first.",
      About::surface | About::drawn_surface};
  Flag roi_snap{*this, "--roi-snap", "End the surface at the last samples inside --roi. Cuts no triangles.",
                About::surface | About::drawn_surface};
  Values<convert::ClipPlane> clip{*this,
                                  "--clip",
                                  "NX,NY,NZ,D",
                                  parse_clip_plane,
                                  "Plane that cuts the surface; keeps the side of N. N is the plane's normal: points "
                                  "with NX x + NY y + NZ z >= D stay, in the coordinates of --roi. The surface is open "
                                  "there, or closed with --cap. Several times for several planes.",
                                  About::surface | About::edit | About::drawn_surface};
  Value<glm::ivec3> resolution{
      *this, "--resolution", "NX,NY,NZ", parse_resolution,
      "Samples of the grid to extract from, along x, y and z. One number is for all axes. The grid covers the same "
      "box; it takes means of the samples along axes that get coarser, and values between them (--kernel) along axes "
      "that get finer. A sparse grid becomes dense: its active voxels and one layer of background. --labels takes the "
      "label of most voxels, and on finer grids the label of the nearest voxel. The voxels of --space index, --roi and "
      "--error are those of the input, the voxels of --simplify those of the new grid. "
      "Default: the input's samples."};
  Value<glm::dvec3> voxel_size{
      *this, "--voxel-size", "SX,SY,SZ", parse_spacing,
      "Voxel size of the grid to extract from. In units of the input's world, in place of --resolution; one number, "
      "such as 0.5, is for all axes. The size is rounded so that whole voxels fill the box; a note tells the result. A "
      "sparse level set that -o writes as a field is measured again: it gets voxels of exactly this size and distances "
      "up to 3 voxels from the surface. That needs cubic voxels and no --kernel."};
  Value<field::ResampleKernel> kernel{
      *this, "--kernel",
      "Interpolation of a finer grid (default: linear). cubic is a smooth curve through the samples (Catmull-Rom). "
      "bspline, the cubic B-spline, is smoother and does not pass through the samples. nearest takes the value of the "
      "nearest sample, also where the grid is coarser. majority does so on finer grids; a coarser grid takes the value "
      "that most voxels in a new voxel have, on a tie that of the nearest sample, else the smallest. --labels works "
      "with nearest and majority only; its default is majority."};
  Values<convert::FilterStep> filters{
      *this, "--filter", "gaussian|median|mean", parse_filter,
      "Filter a level set before extraction. For level sets of VDB files, and of --particles spheres and smooth. Each "
      "value is taken from samples up to N voxels away (median:N, mean:N; default 1), for gaussian:N up to 4 N. "
      "Several times for several filters, in their order. Needs the OpenVDB plug-in."};
  Values<convert::BlurStep> blurs{
      *this, "--blur", "SIGMA|median:N", parse_blur,
      "Blur the field before extraction. SIGMA (up to 16 voxels) is the standard deviation of a Gaussian, in voxels "
      "(1.5) or the input's "
      "units (0.7world); median:N takes the median of samples up to N voxels away. NaN samples are left out. For dense "
      "and sparse fields. Several times for several blurs, after --filter."};
  Flag cap{everyday(*this), "--cap",
           "Close the surface at the data boundary and at cuts. Cuts are those of --roi and --clip.",
           About::surface | About::drawn_surface};
  NanOption nan{*this};
};

// The options of labels, which take the place of iso values.
struct LabelFlags : OptionSet {
  // The options that a command takes: all but --background (`names`), or all.
  enum class Taken { names, all };

  LabelFlags(OptionSet& command, Taken taken);

 private:
  Taken taken_;
  Place only(bool is_taken) { return is_taken ? Place(*this) : Place(); }

 public:
  Value<std::vector<convert::IsoChoice>> chosen{
      *this,
      "--labels",
      "all|L,...",
      parse_labels,
      "Labels of a label map to extract, in place of --iso. all takes every label but the background (the default for "
      "files that name their labels); or list numbers, ranges and names, and exclude labels with !: "
      "1-40,Hippocampus*,!Skull. Each label becomes a mesh of its own, called label L or by its name. Samples must be "
      "integers. Needs --method surface-nets, the default with --labels, or voxels.",
      About::surface};
  Value<std::uint64_t> min_voxels{*this,
                                  "--labels-min-voxels",
                                  "N",
                                  parse_count,
                                  "Leave out labels with fewer than N voxels. A note tells which.",
                                  About::surface};
  Value<std::int64_t> background{
      only(taken_ == Taken::all),
      "--background",
      "L",
      parse_label,
      "Label without a mesh in --labels all (default: 0). With another L, label 0 gets a mesh like the other labels.",
      About::surface};
  Value<std::string> names{*this,
                           "--label-names",
                           "FILE",
                           parse_text,
                           "Table with names and colors of labels. As ITK-SNAP, FreeSurfer or 3D Slicer write "
                           "it. Meshes get the names, and in glb, gltf and ply the colors. Default: the names in "
                           "the file of the labels, else a table beside it (NAME.ctbl, NAME_ColorTable.ctbl, "
                           "NAME_LUT.txt or the only *.ctbl); none: no table.",
                           About::surface};

  // The source of the choice, for messages: --labels, or what implies --labels all.
  std::string asked_by{chosen.name()};

  // Chooses all labels, as --labels all does.
  void choose_all(std::string by) {
    chosen = std::vector{convert::IsoChoice::all_labels()};
    asked_by = std::move(by);
  }

  // Returns whether --labels gives a set: all, or ranges and names. The samples and names of the input decide which
  // labels belong to the set.
  [[nodiscard]] bool is_set_of_labels() const { return chosen && chosen->front().is_label_set(); }
};

// The options that edit a surface after its extraction, besides --simplify and --triangles.
struct EditFlags : OptionSet {
  // The options that a command takes: all but --repair, which needs a mesh file as input (`field`), or all.
  enum class Taken { field, all };

  EditFlags(OptionSet& command, Taken taken);

 private:
  Taken taken_;

 public:
  Value<convert::RepairChoice> repair{
      taken_ == Taken::all ? Place(*this) : Place(),
      "--repair",
      "EDGES",
      parse_repair,
      "Repair a mesh file, before all other edits. Welds vertices of equal positions on boundary edges. Drops "
      "duplicate triangles and those without area. Gives neighbors one winding. Fills holes of up to EDGES edges "
      "(default: 100, at most 1000; 0: none). Faces closed shells outward, and cavities inward. Reports the changes of "
      "each step, then the findings of 'check'.",
      About::surface | About::edit,
      IfLeftOut{"100"}};
  Value<convert::MinComponentSize> least{
      *this,
      "--drop-components",
      "MIN",
      parse_min_component_size,
      "Remove components smaller than MIN. MIN counts triangles (100), or is an area or a "
      "volume: area:40 and volume:5 in voxels, volume:5world in the units of the mesh. "
      "Removing a body removes its cavities; removing a cavity fills it.",
      About::surface | About::edit};
  Flag fill_cavities{*this, "--fill-cavities", "Remove all cavities, and the bodies inside them.",
                     About::surface | About::edit};
  Value<std::uint64_t> largest{*this,
                               "--largest",
                               "N",
                               parse_positive_count,
                               "Keep the N bodies of largest area (default: 1). Their cavities stay. --drop-components "
                               "and --fill-cavities come first.",
                               About::surface | About::edit,
                               IfLeftOut{"1"}};
  Flag split{*this, "--split-components",
             "Write each body as a mesh of its own. The largest comes first, each with its cavities. They are called "
             "'NAME piece 1' and so on in one file, or {piece} in the name after -o gives each its own file.",
             About::surface | About::edit};
  Value<convert::SmoothChoice> smooth{
      *this,
      "--smooth",
      "N[:METHOD[:BAND]]",
      parse_smoothing,
      "Smooth the surface by N passes of a filter. N is at most 1000. taubin (the default) and sinc (a windowed sinc) "
      "keep its size. "
      "BAND, between 0 and 1 (default: 0.1), is the pass band: a smaller one smooths more. weighted is for particles, "
      "as in 25:weighted: it flattens sheets and bulk, and keeps droplets, whose particles have few neighbors. "
      "Boundary vertices stay in place, and those of caps in their plane. Reports the largest move and, for closed "
      "meshes, the change of volume.",
      About::surface | About::edit};

  Value<convert::HollowChoice> hollow{
      *this,
      "--hollow",
      "THICKNESS",
      parse_hollow,
      "Hollow closed bodies, and leave a wall of THICKNESS. State the unit: 2mm (or another unit of --unit), 2world in "
      "the units of the mesh, or 3voxel. The outer surface stays, and each body gets an inner wall at this "
      "distance, also around cavities that it has. Parts that are not thicker than two walls stay solid. Reports the "
      "measured thickness. --drop-components and --smooth come first, --simplify and --triangles later.",
      About::surface | About::edit};

  // Returns the edits without a simplification, which plan_edits() adds.
  [[nodiscard]] convert::SurfaceEdits chosen() const {
    convert::SurfaceEdits edits;
    edits.repair = repair;
    edits.pieces = {least, fill_cavities, largest, split};
    edits.smooth = smooth;
    edits.hollow = hollow;
    return edits;
  }
};

}  // namespace isoextract::cli

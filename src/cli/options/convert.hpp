// The options of convert, and of verify, which takes only the options of the input, of the surface, of the placement,
// of the backend and of the run.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "cli/option.hpp"
#include "cli/options/frames.hpp"
#include "cli/options/input.hpp"
#include "cli/options/meshes.hpp"
#include "cli/options/placement.hpp"
#include "cli/options/run.hpp"
#include "cli/options/surface.hpp"
#include "cli/options/view.hpp"
#include "cli/values.hpp"
#include "convert/conversion_job.hpp"
#include "edit/colormap.hpp"
#include "field/interpolant.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "particle_io/particle_writer.hpp"

namespace isoextract::cli {

// The value of --color-by.
struct ColorFlag {
  std::optional<convert::AttributeChoice> attribute;  // unset: color by iso value
  edit::Colormap map = edit::Colormap::viridis;
  std::optional<std::array<double, 2>> range;
};

// Parses NAME[?][=FROM], then in any order and each at most once :KIND, :spacing=SX,SY,SZ, :origin=X,Y,Z, :nodata=V,
// :volume=K and :component=K|length. Fails with ErrorCode::usage, as parse_color() and parse_opacity() do.
[[nodiscard]] Result<convert::AttributeChoice> parse_attribute(std::string_view text);
// Parses the same form without a kind, but with :MAP and then :MIN,MAX (MIN below MAX) among the settings. The NAME
// "iso" takes only these two.
[[nodiscard]] Result<ColorFlag> parse_color(std::string_view text);
[[nodiscard]] Result<std::vector<double>> parse_opacity(std::string_view text);  // A[,B...], above 0, at most 1

// Kind of the output -o: a mesh format or, without one, a picture of the meshes, the field itself, or the particles.
struct OutputFormat {
  std::optional<mesh_io::MeshFormat> mesh;
  bool picture = false;
  std::optional<volume_io::VolumeFileFormat> field = {};
  std::optional<particle_io::ParticleFileFormat> particles = {};
};
[[nodiscard]] std::vector<Choice<OutputFormat>> output_formats();

// Returns all color maps: "viridis, plasma, ...".
[[nodiscard]] std::string colormap_list();

// The bits of --draco; nullopt: the voxel size decides.
using DracoBits = std::optional<std::uint64_t>;
[[nodiscard]] std::vector<Choice<DracoBits>> draco_bits();

struct ConvertFlags : OptionSet {
  enum class Of { convert, verify };

  explicit ConvertFlags(Of command = Of::convert);
  ConvertFlags(OptionSet& command, Of of);

 private:
  Of of_;
  Place only_convert(OptionGroup group) { return of_ == Of::convert ? in(group) : Place(); }

 public:
  InputFlags input{*this, of_ == Of::convert
                              ? InputUse{"INPUT", "Volumes, particles or mesh files to convert", true}
                              : InputUse{"INPUT", "Volume or particles the mesh was made from", false, 1}};
  Flag masks{
      only_convert(OptionGroup::input), "--masks",
      "Make one label map of masks, one file each. Inputs are files or one folder, all on one grid: samples are 0 "
      "outside and one other value inside. Each mask becomes a mesh named after its file. Neighbors meet without "
      "gaps; overlapping masks keep all their voxels. --labels chooses some by name.",
      About::surface};
  ParticleFlags particles{*this};

  IsoOption isos{
      everyday(in(OptionGroup::surface)), "",
      fmt::format(" Several times for {}. Default: 0 for level sets, the usual value for particles, 0.5 for integers "
                  "with --method surface-nets. Other volumes need one, unless they name labels.",
                  of_ == Of::convert ? "several surfaces" : "the several surfaces of a mesh")};
  SurfaceFlags surface{*this};
  LabelFlags labels{*this, LabelFlags::Taken::all};
  Flag heightfield{only_convert(OptionGroup::surface), "--heightfield",
                   "Make terrain of a picture or array of heights. For single images (TIFF, GeoTIFF, PNG, OpenEXR), "
                   "NumPy arrays [y, x] and elevation models; several files are frames. The sample at column x and row "
                   "y becomes a vertex; the third number of --spacing scales the heights. Squares with a NaN corner "
                   "are holes, unless --nan error refuses them.",
                   About::surface};
  Value<HeightBase> base{only_convert(OptionGroup::surface),
                         "--base",
                         "H|none",
                         parse_height_base,
                         "Floor of the terrain (default: below its lowest point). With --heightfield: walls and a flat "
                         "floor at the height H close it; the default lies a tenth of the range of heights below the "
                         "lowest. none leaves it open.",
                         About::surface};
  Value<std::uint64_t> relaxations{
      in(OptionGroup::surface),
      "--relax",
      "N",
      parse_relaxations,
      fmt::format("Passes that smooth surface nets (default: {}). Each moves vertices toward their neighbors and back, "
                  "within their cells; 0 leaves them at the corners of voxels.",
                  extract::kDefaultRelaxations),
      About::surface};
  Flag no_merge{in(OptionGroup::surface), "--no-merge",
                "Keep each voxel face as two triangles. With --method voxels, which otherwise merges coplanar faces to "
                "large rectangles.",
                About::surface | About::voxel_faces};
  Flag t_junctions{in(OptionGroup::surface), "--t-junctions",
                   "Draw each merged rectangle with two triangles. With --method voxels. These are the fewest "
                   "triangles, but corners lie on edges of others, and the mesh is not closed edge by edge.",
                   About::surface | About::voxel_faces};
  Value<convert::Touching> touching{
      in(OptionGroup::surface), "--touching",
      "Move touching sheets of a surface apart, or keep them. apart: vertices at equal positions, where sheets touch, "
      "move 0.001 voxels to their own side, so that programs that weld vertices by position find a closed 2-manifold; "
      "keep: no vertex moves. Default: apart for stl, whose readers weld, else keep.",
      About::surface};
  Value<std::vector<check::Requirement>> required{
      only_convert(OptionGroup::surface),
      "--require",
      "WORD,WORD,...",
      parse_requirements,
      "Properties each mesh must have; else exit code 6. Nothing is "
      "written then. Words are those of --require of 'isoextract check', such as printable, but not normals. For "
      "printable and no-self-intersections, "
      "vertices of triangles that intersect first move toward "
      "their neighbors. Reports how many moved, and how far.",
      About::surface};
  Value<convert::Normals> normals{
      only_convert(OptionGroup::surface), "--normals",
      "Normals to store. none; flat, one per triangle; smooth, the gradient of the field at each vertex; area, the "
      "area-weighted mean of the triangles around each vertex. Default for glb and gltf: smooth; area for terrain and "
      "mesh files; none for surface nets and voxels. None for ply, obj and drc; stl always has flat ones. With --cap "
      "and --simplify a vertex has one normal for each side of a crease.",
      About::surface};
  Value<convert::SimplifyBound> simplify{
      everyday(in(OptionGroup::surface)),
      "--simplify",
      "ERR",
      parse_simplify_bound,
      "Remove triangles within a distance of ERR. No point of either mesh is farther than ERR from the other: 0.1 or "
      "0.1voxel in voxels, 0.5world in the units of the mesh. The distance is measured and reported. Boundaries get "
      "fewer vertices and stay within ERR, too. With --labels, neighbors keep common faces, and all meshes are in "
      "memory together.",
      About::surface | About::edit};
  Value<convert::TriangleCount> triangles{
      in(OptionGroup::surface),
      "--triangles",
      "N|P%",
      parse_triangle_count,
      "Reduce each surface to N triangles, or to P percent. 50k means 50,000, 2M two million. More triangles stay if "
      "the topology needs them. The distance is measured and reported. With --simplify, the limit that comes first "
      "ends the reduction. With "
      "--labels, N and P count all labels together, triangles of common faces once.",
      About::surface | About::edit};
  Value<convert::EmptyPolicy> empty{only_convert(OptionGroup::surface), "--empty",
                                    "What to do if there is no surface (default: error). error fails; skip writes no "
                                    "file and removes an old one of that name; write writes an empty mesh."};

  EditFlags edits{*this, of_ == Of::convert ? EditFlags::Taken::all : EditFlags::Taken::field};

  Values<convert::AttributeChoice> attributes{
      only_convert(OptionGroup::vertices),
      "--attribute",
      "NAME[?][=FROM][:KIND][:KEY=V...]",
      parse_attribute,
      "Attribute for the vertices, interpolated. Several times for several attributes. FROM is an attribute of the "
      "particles, another grid of the file (velocity[x], or velocity for all components), another file, or a grid of "
      "another file: FILE.vdb[GRID]; without FROM it has the same NAME. With '?' an input that lacks it is converted "
      "without "
      "it. KIND is scalar, color, vector, point or normal; vectors, points and normals turn and scale with the mesh. "
      "Without KIND the file decides, then the name (v, velocity, N, Cd, P, ...). KEY is spacing or origin, for a file "
      "that states none and differs in shape from the input; nodata, in place of --nodata; volume or component, for a "
      "file with several. For glb, gltf, ply and drc.",
      About::surface};
  Value<ColorFlag> color{
      only_convert(OptionGroup::vertices),
      "--color-by",
      "NAME[?][=FROM][:KEY=V...][:MAP][:MIN,MAX]",
      parse_color,
      fmt::format(
          "Color the vertices by an attribute or by iso value. MIN to MAX is the range of the colors (default: the "
          "values on each surface; of a sequence, the values in all frames); an attribute of several components counts "
          "by its length in the input. iso "
          "gives each surface of a glb or gltf a color by its iso value, and outer surfaces become "
          "transparent. MAP is one of {} (default: {}).",
          colormap_list(), word_of(edit::Colormap{})),
      About::surface};
  Value<std::vector<double>> opacity{only_convert(OptionGroup::vertices),
                                     "--opacity",
                                     "A[,B...]",
                                     parse_opacity,
                                     "Opacity of glb or gltf surfaces, above 0, at most 1. One for all, or one "
                                     "for each --iso in order. Default: "
                                     "opaque; with --color-by iso from 0.25 for the outermost to 1 for the innermost.",
                                     About::surface};

  BatchFlags batch{of_ == Of::convert ? this : nullptr};

  PlacementFlags placement{*this};

  Value<std::string> output{
      everyday(only_convert(OptionGroup::output)), "-o,--output", "FILE", parse_text,
      "File to write; its extension chooses the format. Default: the input's name with .glb, or with the extension of "
      "--format, in the current folder; input from stdin needs a name. - is stdout and needs --format. .vdb, .nrrd, "
      ".npy and .vti write the "
      "field itself, resampled and filtered: it needs no --iso and takes no options of surfaces. .bgeo, .vtu and .xyz "
      "write the chosen particles with their attributes. .png draws the surfaces. "
      "{iso} stands for the iso value as it was given (0.5, p99), and gives each surface its own file. {label} and "
      "{name} stand for the number and the name of a label, {piece} for the number of a body, with "
      "--split-components. {step} stands for the time step that a file of particles states. A "
      "file gets its name when it is complete. A killed run may leave a file .isoextract-HOST-PID-N; the next run on "
      "the same machine that writes into the folder removes it."};
  Value<OutputFormat> format{only_convert(OptionGroup::output), "--format", output_formats(),
                             "Format of the output, whatever the extension."};
  ViewFlags view{of_ == Of::convert ? this : nullptr,
                 {"--background-color", "light gray",
                  "(default: 960x720). Also of the pictures on a page or a contact sheet. Default on contact sheets "
                  "and on pages of several frames: 320x240.",
                  "In the coordinates of the surfaces; pages and contact sheets take those of the mesh file.",
                  "the center of the surfaces"}};
  Flag half{only_convert(OptionGroup::output), "--half", "Store a field as 16-bit floats (.vdb, .npy)."};
  Value<std::string> report{everyday(only_convert(OptionGroup::output)), "--report", "FILE", parse_text,
                            "Write a JSON report of the conversion. It has options, input, time and memory of each "
                            "stage, what was left out, and the facts of each mesh, which take time and memory of their "
                            "own. A failed conversion writes its report, too, with the error."};
  Value<std::string> html{
      only_convert(OptionGroup::output), "--html", "FILE", parse_text,
      "Write a page about the conversion or the sequence. It needs no other file: pictures of at most 12 meshes, a "
      "table, plots over the frames by gnuplot, the error where it is measured, and what was left out."};
  Value<std::string> contact_sheet{only_convert(OptionGroup::output), "--contact-sheet", "FILE", parse_text,
                                   "Draw up to 60 frames side by side, as a .png."};
  Flag ascii{only_convert(OptionGroup::output), "--ascii", "Write ply or stl as text, not binary.",
             About::surface | About::mesh_file};
  Value<DracoBits> draco{
      only_convert(OptionGroup::output),
      "--draco",
      draco_bits(),
      "Compress glb or gltf with Draco; drc always is. (KHR_draco_mesh_compression.) Positions are rounded to a "
      "lattice that all regions of a volume share. Its step is at most 1/32 voxel (auto, the default), or the given "
      "number of bits spans the volume. The file is decoded again, and the distance that vertices moved is reported.",
      About::surface | About::mesh_file,
      IfLeftOut{"auto"}};
  Flag quantize{only_convert(OptionGroup::output), "--quantize",
                "Write glb or gltf with 16-bit positions. On the lattice of --draco: the step is at most 1/32 voxel, "
                "unless the volume is longer than 65,535 such steps. Normals have 8 bits (KHR_mesh_quantization).",
                About::surface | About::mesh_file};
  Flag meshopt{only_convert(OptionGroup::output), "--meshopt",
               "Compress glb or gltf with meshoptimizer, lossless. (EXT_meshopt_compression.) Smaller together with "
               "--quantize and --optimize-order.",
               About::surface | About::mesh_file};
  Flag optimize_order{only_convert(OptionGroup::output), "--optimize-order",
                      "Reorder vertices and triangles for GPUs. It helps compression, too.",
                      About::surface | About::mesh_file};

  Value<field::Interpolation> error{
      only_convert(OptionGroup::run),
      "--error",
      choices_of_words<field::Interpolation>(),
      "Measure the distance of the mesh to the isosurface. The isosurface is that of the data, interpolated linearly "
      "along each axis (trilinear, the default) or smoothly (tricubic); for demo fields also that of the formula.",
      About::surface,
      IfLeftOut{std::string(word_of(field::Interpolation{}))}};
  Value<convert::Backend> backend{in(OptionGroup::run), "--backend",
                                  "Backend that extracts (default: cpu). cpu, gpu, or auto: a GPU if there is one that "
                                  "is not a software renderer. The triangles are the same.",
                                  About::surface};
  DeviceFlags device{*this};
  Flag verify{only_convert(OptionGroup::run), "--verify",
              "Extract with both backends and compare. Where CPU and GPU differ in a triangle, the program exits with "
              "code 6 and writes no file.",
              About::surface};
  Value<std::string> config{only_convert(OptionGroup::run), "--config", "FILE", parse_text,
                            "Read options from a TOML file. Keys are the long option names without dashes, and input. "
                            "An option that can be repeated takes a list, one without a value takes true. Options on "
                            "the command line win. Relative paths are relative to the current folder."};
  Flag explain{only_convert(OptionGroup::run), "--explain", "Say what was left out and why, with counts and times."};
  RunFlags run{*this};
};

// The options of the conversion that made the mesh, and the mesh.
struct VerifyFlags : OptionSet {
  VerifyFlags();

  ConvertFlags conversion{*this, ConvertFlags::Of::verify};
  Value<std::string> mesh{
      in(OptionGroup::input), "MESH", "MESH", parse_text,
      fmt::format("Mesh to verify (default: none, compare the backends). One of {}. The mesh records its placement, "
                  "else its extension gives the default; options of placement overrule both.",
                  mesh_io::mesh_extensions())};
  JsonFlag json{in(OptionGroup::output)};
};

}  // namespace isoextract::cli

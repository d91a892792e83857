// The options of convert, and of verify, which takes those that decide about the triangles of a mesh.
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
#include "cli/options/placement.hpp"
#include "cli/options/run.hpp"
#include "cli/options/surface.hpp"
#include "cli/values.hpp"
#include "convert/conversion_job.hpp"
#include "edit/colormap.hpp"
#include "field/interpolant.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "render/camera.hpp"

namespace isoextract::cli {

// What --color-by says.
struct ColourFlag {
  std::optional<convert::AttributeChoice> attribute;  // nothing: the iso values
  edit::Colormap map = edit::Colormap::viridis;
  std::optional<std::array<double, 2>> range;
};

// NAME[?][=FROM], and behind it in any order :KIND, :spacing=SX,SY,SZ, :origin=X,Y,Z, :nodata=V, :volume=K and
// :component=N.
[[nodiscard]] Result<convert::AttributeChoice> parse_attribute(std::string_view text);
// Likewise without a kind, and with :MAP and then :MIN,MAX among these.
[[nodiscard]] Result<ColourFlag> parse_colour(std::string_view text);
[[nodiscard]] Result<std::vector<double>> parse_opacity(std::string_view text);  // A[,B...], above 0, at most 1

// What -o is written as: a format of meshes or, without one, a picture of them or the field itself as an OpenVDB file.
struct OutputFormat {
  std::optional<mesh_io::MeshFormat> mesh;
  bool picture = false;
};
[[nodiscard]] std::vector<Choice<OutputFormat>> output_formats();

// "viridis, magma"
[[nodiscard]] std::string colormap_list();

// The bits of --draco, or nothing in it where the voxel says.
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
  InputFlags input{*this, of_ == Of::convert ? InputUse{"INPUT", "The volume or particles to convert", true}
                                             : InputUse{"INPUT", "The volume or particles to verify with", false, 1}};
  ParticleFlags particles{*this};

  IsoOption isos{in(OptionGroup::surface), "",
                 fmt::format(" Several times for {}. (default: 0 of a level set, the usual value of particles; other "
                             "inputs need one).",
                             of_ == Of::convert ? "several surfaces" : "the several surfaces of a mesh")};
  SurfaceFlags surface{*this};
  Value<std::vector<convert::IsoChoice>> labels{
      in(OptionGroup::surface),
      "--labels",
      "all|L,...",
      parse_labels,
      "Of a label map, whose samples are integers, the surface of each of these labels as a mesh of its own, in "
      "place of --iso: all but 0, or those that are listed. They are called label L. With --method surface-nets, which "
      "is the default then, or voxels.",
      About::surface};
  Value<std::string> label_names{
      only_convert(OptionGroup::surface),
      "--label-names",
      "FILE",
      parse_text,
      "Names and colours of labels, as a table that ITK-SNAP, FreeSurfer or 3D Slicer writes: meshes are called so, "
      "and have these colours in glb, gltf and ply.",
      About::surface};
  Value<std::uint64_t> relaxations{
      in(OptionGroup::surface),
      "--relax",
      "N",
      parse_relaxations,
      fmt::format("With --method surface-nets: how many times vertices move towards their neighbours and back, "
                  "each within its cell; 0 leaves them at the corners of voxels (default: {}).",
                  extract::kUsualRelaxations),
      About::surface};
  Flag no_merge{in(OptionGroup::surface), "--no-merge",
                "With --method voxels: leave each face by itself, as two triangles. Otherwise coplanar faces are "
                "merged to large rectangles.",
                About::surface | About::voxel_faces};
  Flag t_junctions{in(OptionGroup::surface), "--t-junctions",
                   "With --method voxels: draw each rectangle with two triangles, though corners of others lie within "
                   "its sides. These are the fewest triangles, but the mesh is not closed edge by edge.",
                   About::surface | About::voxel_faces};
  Value<convert::Normals> normals{
      only_convert(OptionGroup::surface), "--normals",
      "Normals to store: none, one a triangle, or one a vertex: smooth is the field's gradient, area the mean "
      "of the triangles around by their areas (default: smooth for glb and gltf, none for ply, obj and drc; "
      "stl always has one a triangle). With --cap and --simplify a vertex gets a normal for each side of a crease.",
      About::surface};
  Value<convert::SimplifyBound> simplify{
      in(OptionGroup::surface),
      "--simplify",
      "ERR",
      parse_simplify_bound,
      "Leave out triangles as long as no point of either mesh is farther than ERR from the other: 0.1 or "
      "0.1voxel in voxels, 0.5world in the units of the written mesh. The distance is measured and told. Open "
      "borders stay within ERR, too, with fewer vertices.",
      About::surface | About::edit};
  Value<convert::TriangleCount> triangles{
      in(OptionGroup::surface),
      "--triangles",
      "N|P%",
      parse_triangle_count,
      "Leave N triangles of each surface, or P percent of them, where its topology lets that many go; how far "
      "the surface moved is measured and told. With --simplify it ends where the first of the two is reached.",
      About::surface | About::edit};
  Value<convert::EmptyPolicy> empty{
      only_convert(OptionGroup::surface), "--empty",
      "What to do where there is no surface: fail, write no file and remove an old one of that name, or write an empty "
      "one (default: error)."};

  EditFlags edits{*this};

  Values<convert::AttributeChoice> attributes{
      only_convert(OptionGroup::vertices),
      "--attribute",
      "NAME[?][=FROM][:KIND][:KEY=V...]",
      parse_attribute,
      "Give the vertices this attribute, interpolated; several times for several. FROM is an attribute of the "
      "particles, or of a volume another grid of the file (velocity[x], or velocity with its components), "
      "another file, or a grid of one: FILE.vdb[GRID]. Without it, it is called NAME there too. With '?' an input "
      "that lacks it is converted without it. KIND is scalar, color, vector, point or normal (default: as the file "
      "says, else by the name: v, velocity, N, Cd, P, ...): vectors, points and normals turn and scale with the mesh. "
      "KEY is spacing or origin, for a file that states none and has not the input's shape, or nodata, in place of "
      "--nodata, or volume or component, of a file of several. For glb, gltf, ply and drc.",
      About::surface};
  Value<ColourFlag> colour{
      only_convert(OptionGroup::vertices),
      "--color-by",
      "NAME[?][=FROM][:KEY=V...][:MAP][:MIN,MAX]",
      parse_colour,
      fmt::format("Colour the vertices by this attribute, of several components by their length in the input, from MIN "
                  "to MAX (default: the range over the vertices of each surface). --color-by iso[:MAP][:MIN,MAX] gives "
                  "each surface of a glb or gltf a colour by its iso value, and outer ones let inner ones be "
                  "seen. MAP is one of {} (default: {}).",
                  colormap_list(), word_of(edit::Colormap{})),
      About::surface};
  Value<std::vector<double>> opacity{
      only_convert(OptionGroup::vertices),
      "--opacity",
      "A[,B...]",
      parse_opacity,
      "Opacity of the surfaces of a glb or gltf, above 0 and at most 1: one for all, or one for each --iso in "
      "their order (default: opaque; with --color-by iso from 0.25 for the outermost to 1 for the innermost).",
      About::surface};

  BatchFlags batch{of_ == Of::convert ? this : nullptr};

  PlacementFlags placement{*this};

  Value<std::string> output{
      only_convert(OptionGroup::output), "-o,--output", "FILE", parse_text,
      "The mesh file; its extension chooses the format. A name that ends in .vdb is that of the field "
      "itself, resampled and filtered where that is asked for, as an OpenVDB file in place of a "
      "mesh, which needs no --iso and takes no option of surfaces. One that ends in .png is that of a picture of the "
      "surfaces. (default: the input's name with .glb, in "
      "the current folder; an input from stdin has none). '-' is stdout and needs --format. "
      "'{iso}' stands for the iso value as it was given, be it a number or a word such as p99, and gives each "
      "its own file; '{piece}' is the number of a piece, with --split-components. A file gets its name when it is "
      "whole. What a killed run leaves, on some file systems, is called "
      ".isoextract-HOST-PID-N and stays until the next run writes into that folder."};
  Value<OutputFormat> format{only_convert(OptionGroup::output), "--format", output_formats(),
                             "Format of the output, whatever the extension."};
  Value<render::PictureSize> size{only_convert(OptionGroup::output),
                                  "--size",
                                  "WxH",
                                  parse_picture_size,
                                  "Of a picture, in pixels (default: 960x720).",
                                  About::picture};
  Value<render::ViewAngles> camera{
      only_convert(OptionGroup::output),
      "--camera",
      "AZ,EL[,DISTANCE]",
      render::parse_view_angles,
      "Where a picture is drawn from: degrees around the up axis from the front, degrees above the ground, and how far "
      "from the middle of the surfaces (default: 35,20, and so far that all of them are seen).",
      About::picture};
  Value<glm::dvec3> look_at{
      only_convert(OptionGroup::output),
      "--look-at",
      "X,Y,Z",
      parse_vector,
      "What the camera of a picture looks at, in the coordinates of the surfaces, in place of their middle. "
      "With the distance of --camera all frames of a sequence have one camera.",
      About::picture};
  Flag half{only_convert(OptionGroup::output), "--half",
            "Store a field with values of 16 bits: files of half the size or less."};
  Value<std::string> report{only_convert(OptionGroup::output), "--report", "FILE", parse_text,
                            "Write a JSON report of the conversion: options, input, stages with time and memory, what "
                            "was left out, and the facts of each mesh, which take time and memory of their own. Of a "
                            "conversion that fails, it says why."};
  Value<std::string> html{only_convert(OptionGroup::output), "--html", "FILE", parse_text,
                          "Write a page about the conversion, or all frames of it, that needs no other file: pictures "
                          "of at most 12 of its meshes, a table and, of several frames, plots by gnuplot, the error "
                          "where it is measured, what was left out."};
  Value<std::string> contact_sheet{only_convert(OptionGroup::output), "--contact-sheet", "FILE", parse_text,
                                   "Draw the meshes of at most 60 frames side by side, as a .png."};
  Flag ascii{only_convert(OptionGroup::output), "--ascii", "Write ply or stl as text instead of binary.",
             About::surface | About::mesh_file};
  Value<DracoBits> draco{
      only_convert(OptionGroup::output),
      "--draco",
      draco_bits(),
      "Compress glb or gltf with Draco (KHR_draco_mesh_compression); drc always is. Positions are rounded to a "
      "lattice that all regions of a volume share: its step is at most a 32nd of a voxel (auto, the default), "
      "or such that the whole volume takes so many bits. What the file unpacks to is compared with the mesh, "
      "and how far vertices moved is told.",
      About::surface | About::mesh_file,
      IfLeftOut{"auto"}};
  Flag quantize{only_convert(OptionGroup::output), "--quantize",
                "Write glb or gltf with positions of 16 bits, on the same lattice, and normals of 8 "
                "(KHR_mesh_quantization).",
                About::surface | About::mesh_file};
  Flag meshopt{only_convert(OptionGroup::output), "--meshopt",
               "Compress glb or gltf with meshoptimizer (EXT_meshopt_compression), without loss; smaller with "
               "--quantize and --optimize-order.",
               About::surface | About::mesh_file};
  Flag optimize_order{only_convert(OptionGroup::output), "--optimize-order",
                      "Put vertices and triangles into an order that graphics cards and compression like.",
                      About::surface | About::mesh_file};

  Value<field::Interpolation> error{
      only_convert(OptionGroup::run),
      "--error",
      choices_of_words<field::Interpolation>(),
      "Measure how far the mesh is from the isosurface of the data, interpolated linearly along each axis "
      "(the default) or smoothly; of demo fields also how far from the formula.",
      About::surface,
      IfLeftOut{std::string(word_of(field::Interpolation{}))}};
  Value<convert::Backend> backend{
      in(OptionGroup::run), "--backend",
      "What extracts: the processor, a GPU, or a GPU where there is one that is not software (default: cpu). The "
      "triangles are the same.",
      About::surface};
  DeviceFlags device{*this};
  Flag verify{only_convert(OptionGroup::run), "--verify",
              "Extract with the other backend as well, CPU or GPU, and compare triangle by triangle. Where they "
              "differ, exit with code 6 and do not write the file.",
              About::surface};
  Value<std::string> config{
      only_convert(OptionGroup::run), "--config", "FILE", parse_text,
      "Take options from a TOML file: keys are their long names without dashes, and input; an option that may be given "
      "several times takes a list, one without a value takes true. What the command line has as well wins over the "
      "file. Relative paths in it are relative to the current folder."};
  Flag explain{only_convert(OptionGroup::run), "--explain", "Tell what was left out and why, with counts and times."};
  RunFlags run{*this};
};

// How the mesh was converted, and which it is.
struct VerifyFlags : OptionSet {
  VerifyFlags();

  ConvertFlags conversion{*this, ConvertFlags::Of::verify};
  Value<std::string> mesh{
      in(OptionGroup::input), "MESH", "MESH", parse_text,
      fmt::format(
          "A mesh that was written from it: {}; its extension says how it was placed unless options do. Without "
          "one the backends are compared with each other.",
          mesh_io::mesh_extensions())};
  JsonFlag json{in(OptionGroup::output)};
};

}  // namespace isoextract::cli

#include "cli/shared_options.hpp"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/edit_options.hpp"
#include "volumes/particle_format.hpp"

namespace isoextract::cli {
namespace {

// Those that are files.
std::vector<Choice<std::string>> input_formats() {
  std::vector<Choice<std::string>> formats;
  for (const volumes::VolumeFormat* format : volumes::volume_formats()) {
    const volumes::FormatDescription& about = format->about();
    if (about.prefix.empty()) formats.push_back({about.id, about.id});
  }
  for (const volumes::ParticleFormatDescription& about : volumes::particle_format_descriptions()) {
    const auto is_it = [&](const Choice<std::string>& other) { return other.name == about.id; };
    if (std::ranges::none_of(formats, is_it)) formats.push_back({about.id, about.id});
  }
  return formats;
}

std::vector<Choice<convert::LengthUnit>> units() {
  std::vector<Choice<convert::LengthUnit>> choices;
  for (const convert::LengthUnit& unit : convert::length_units()) choices.push_back({std::string(unit.name), unit});
  return choices;
}

std::vector<Choice<UnitChoice>> units_of_input() {
  std::vector<Choice<UnitChoice>> choices{{std::string(convert::kUnitOfFile), {}}};
  for (const convert::LengthUnit& unit : convert::length_units()) choices.push_back({std::string(unit.name), {unit}});
  return choices;
}

// "weight (a fixed weight for each particle), sph (...)"
std::string particle_methods() {
  std::vector<std::string> methods;
  for (const points::MethodInfo& method : points::kMethods) {
    methods.push_back(fmt::format("{} ({}; iso {} and cells of {} radii by default)", method.id, method.help,
                                  method.iso, method.cell_size));
  }
  return fmt::format("{}", fmt::join(methods, ", "));
}

// "Marching cubes, or marching tetrahedra with six a cell"
std::string method_help() {
  std::vector<std::string_view> methods;
  for (const extract::MethodInfo& method : extract::kMethods) methods.push_back(method.help);
  std::string text = fmt::format("{}", fmt::join(methods, ", or "));
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

constexpr const char* kQuietText = "Say nothing but errors and, on stdout, results.";

}  // namespace

void declare_input(CLI::App& app, InputFlags& flags, const std::string& metavar, const std::string& what,
                   VolumesTaken volumes) {
  const Group group(app, "Input");
  group.values<std::string>(
      "INPUT", metavar, flags.inputs, parse_text,
      fmt::format("{}: a path, - for stdin, or demo:NAME (see 'isoextract help demo'). A file that is "
                  "named like a command is written ./NAME.",
                  what));
  group.values<std::string>("--grid", "NAME", flags.grids, parse_text,
                            "Grid of a VDB file or array of an .npz, as 'isoextract info' lists it: NAME, or NAME[k] "
                            "where names repeat. A conversion takes several: each has its own surfaces.");
  const bool takes_all = volumes == VolumesTaken::all;
  group.value(
      "--volume", takes_all ? "K|all" : "K", flags.volume, parse_volume,
      fmt::format("Volume of a NIfTI, NRRD, NPY or raw file that holds several, such as time steps, or frame of "
                  "a file of particles: its number, counted from 0{}. 'isoextract info' tells how many there "
                  "are.",
                  takes_all ? ", or each of them" : ""));
  group.value("--component", "K|length", flags.component, parse_component,
              "Of a NIfTI, NRRD or NumPy file with several numbers a sample, such as vectors, colours and complex "
              "numbers: one, counted from 0, or their length. A NumPy array of four axes is then [z, y, x, c].");
  group.choice("--input-format", flags.format, input_formats(),
               "Format of the input (default: by content, then by extension).");
  group.value("--dims", "NX,NY,NZ", flags.dims, parse_dims,
              "Samples along x (fastest), y and z of a raw file. 48x62x42 is the same as 48,62,42.");
  group.choice("--dtype", flags.dtype, "Type of a raw file's samples (default: u8).");
  group.choice("--endian", flags.endian, {{"little", std::endian::little}, {"big", std::endian::big}},
               "Byte order of a raw file's samples (default: little).");
  group.value("--skip", "BYTES", flags.skip, parse_size, "Bytes before a raw file's first sample (default: 0).");
  group.choice(
      "--axis-order", flags.axis_order,
      "What the axes of a NumPy array or raw file are, the last of them the fastest where the file has no order "
      "of its own (default: zyx). --dims are along x, y and z all the same.");
  group.value("--nodata", "V", flags.no_data, parse_number,
              "Samples of this value stand for no data: they are not numbers, and --nan says what that means; it is "
              "outside then unless it is given. Integers become f32, those of 32 bits f64. Not of sparse grids.");
  group.value("--spacing", "SX,SY,SZ", flags.spacing, parse_spacing,
              "Distance of the samples along each axis, or one number for all; replaces what the file says.");
  group.value("--origin", "X,Y,Z", flags.origin, parse_vector,
              "World position of the first sample; replaces what the file says.");
  group.choice("--inside", flags.inside,
               "Which side of an iso value is inside: above as in densities, below as in level sets (default: as the "
               "file says, else above), or away-from-zero for fields of both signs: above a positive iso value, below "
               "a negative one. A value equal to the iso value is outside.");
  group.value("--memory-limit", "SIZE", flags.memory_limit, parse_size, kMemoryLimitText);
  group.flag("--in-process", flags.in_process,
             "Read files of plug-ins (VTK, OpenVDB's points and vectors) in the program's own process, not in a child "
             "process with limits. Only for files that you trust: a damaged one can crash the program, hang it, or "
             "take more memory than --memory-limit.");
}

void declare_particles(CLI::App& app, ParticleFlags& flags) {
  const Group group(app, "Particles");
  const convert::ParticleOptions usual;
  group.choice("--particles", flags.method,
               fmt::format("The input is particles, and becomes a field by {} (default: {}). Files that can only be "
                           "particles need no option; an NPY array of N rows does.",
                           particle_methods(), word_of(usual.method)));
  group.value("--radius", "R", flags.radius, parse_positive,
              "Radius of a particle, in the units of the file (default: half the median distance to the nearest one, "
              "of each file by itself; give one for a sequence). With --particles spheres and smooth each particle has "
              "its own by default where the file has an attribute pscale or radius.");
  group.value(
      "--smoothing-length", "L", flags.smoothing_length, parse_positive,
      fmt::format("Smoothing length of the kernels, in radii; they reach twice as far, as do the particles that "
                  "--particles smooth averages (default: {}).",
                  usual.smoothing_length));
  group.value("--cell-size", "C", flags.cell_size, parse_positive,
              "Distance of the field's samples, in radii (default: that of the method).");
  group.value("--weight", "W", flags.weight, parse_positive,
              fmt::format("What a particle adds with --particles weight (default: {}).", usual.weight));
  group.choice("--deposit", flags.deposit,
               fmt::format("Where that goes: to the nearest sample, or shared among the eight around (default: {}).",
                           word_of(usual.deposit)));
  group.value("--columns", "x=A,y=B,z=C", flags.columns, parse_columns,
              "Which columns of a table are x, y and z: their names, or their numbers counted from 1 (default: as the "
              "file names them).");
}

void declare_verbosity(const Group& group, RunFlags& flags) {
  group.flag("-q,--quiet", flags.quiet, kQuietText);
  group.flag("-v,--verbose", flags.verbose, "Say also what each stage took, and the peak of memory.");
  group.help_flag();
}

void declare_run(CLI::App& app, RunFlags& flags) {
  const Group group(app, "Run");
  group.value("--threads", "N", flags.threads, parse_thread_count,
              "Threads to use (default: all). The output does not depend on it. With 1 no other is started.");
  declare_verbosity(group, flags);
}

void declare_nan(const Group& group, std::optional<extract::NanPolicy>& policy) {
  group.choice("--nan", policy,
               "What a sample that is not a number means: the end, outside, or a hole in the surface, left by the "
               "cells that touch it (default: error). With outside, particles at places that are no numbers are left "
               "out and counted.");
}

void declare_device(const Group& group, DeviceFlags& flags) {
  group.value("--device", "N|cuda:N|NAME", flags.device, parse_device,
              "The GPU to use: its number, its number in CUDA, or a part of its name; 'isoextract devices' lists them "
              "(default: the first that is not software).");
  group.value("--gpu-memory", "SIZE", flags.gpu_memory, parse_size,
              "What samples and triangles may take on the GPU at a time; larger volumes pass through in slabs, and the "
              "output does not depend on it (default: a quarter of what the GPU has, 1G where it does not tell).");
}

void declare_backends(const Group& group, std::optional<std::vector<NamedBackend>>& backends,
                      const std::string& by_default) {
  group.value(
      "--backends", "B,B,...", backends, parse_backends,
      fmt::format("Of cpu, gpu, gpu:points (marching cubes without tessellation) and gpu:rows (cells row by row "
                  "instead of in groups of 2 x 2 x 2) (default: {}).",
                  by_default));
}

void declare_surface(const Group& group, SurfaceFlags& flags) {
  group.choice("--method", flags.method, fmt::format("{} (default: {}).", method_help(), extract::method_ids()[0]));
  group.value("--roi", "X0,Y0,Z0,X1,Y1,Z1", flags.roi, parse_box,
              "Only the part of the surface in this box, given by its smaller and larger corner in the input's world "
              "coordinates (with --space index in voxel coordinates). Triangles are cut at faces that lie between "
              "samples, and the surface is open there, or closed with --cap. Voxels and surface nets stay whole.");
  group.flag("--roi-snap", flags.roi_snap, "End the surface at the outermost samples in the --roi, and cut nothing.");
  group.values(
      "--clip", "NX,NY,NZ,D", flags.clip, parse_clip_plane,
      "Keep of the surface what lies on the side of a plane that its normal N points to: NX x + NY y + NZ z >= "
      "D, in the same coordinates. Triangles are cut, and the surface is open there, or closed with --cap. Several "
      "times for several planes.");
  group.value("--resolution", "NX,NY,NZ", flags.resolution, parse_resolution,
              "Extract from a grid of so many samples over the same box, or one number for all axes: means of the "
              "input's samples along axes that get fewer, values between them along those that get more (default: the "
              "input's samples themselves). A sparse grid becomes dense: its active voxels and one of background "
              "around them. Of --labels the nearest samples. --space index and --roi keep "
              "the input's voxel coordinates, --error its voxels; those of --simplify are the grid's.");
  group.value("--voxel-size", "SX,SY,SZ", flags.voxel_size, parse_spacing,
              "In place of --resolution: the edges of that grid's voxels in units of the input's world, or one number "
              "for all, such as 0.5. They are changed as little as makes them divide the box, and a note says so.");
  group.choice("--kernel", flags.kernel,
               "What is between the input's samples where that grid is finer: a line from one to the next; a smooth "
               "curve through them (Catmull-Rom); or the cubic B-spline, which is smoother and not through them "
               "(default: linear). nearest takes the nearest sample, also where that grid is coarser: no value is made "
               "that the input does not have. It is the one kernel of --labels.");
  group.values("--filter", "gaussian|median|mean", flags.filters, parse_filter,
               "Smooth a level set, of a VDB file or of --particles spheres or smooth, before anything else is done "
               "with it: each value is taken from those up to 1 voxel away or, as in gaussian:3, up to 3. Several "
               "times for several "
               "filters, one after the other. Needs the plug-in around OpenVDB.");
  declare_blur(group, flags);
  group.flag("--cap", flags.cap, "Close the surface where it leaves the data or the --roi, and where --clip cuts it.");
  declare_nan(group, flags.nan);
}

void declare_quiet(CLI::App& app, bool& quiet) {
  const Group run(app, "Run");
  run.flag("-q,--quiet", quiet, kQuietText);
  run.help_flag();
}

void declare_frame_range(const Group& group, std::optional<batch::FrameRange>& frames, const std::string& text) {
  group.value<batch::FrameRange>(
      "--frames", "A-BxS,...", frames, [](std::string_view range) { return batch::FrameRange::parse(range); }, text);
}

void declare_placement(CLI::App& app, PlacementFlags& flags) {
  const Group group(app, "Placement");
  group.choice("--space", flags.space,
               "Coordinates of the mesh: the input's world, or voxels counted from 0 (default: world).");
  group.choice("--up", flags.up,
               "The axis of the input's world that points up (default: z). glb and gltf prescribe y up, so z-up "
               "input is turned for them: (x, y, z) becomes (x, z, -y). ply, obj, stl and drc keep the input's axes.");
  group.choice("--up-out", flags.up_out,
               "The axis of the mesh that points up (default: y in glb and gltf, that of --up in others). From y up to "
               "z up (x, y, z) becomes (x, -z, y).");
  group.choice("--to-space", flags.to_space,
               "Mirror x and y of a scan's world as it takes: ras (right, anterior, superior, as NIfTI) or lps (left, "
               "posterior, superior, as DICOM). The file has to say which of them its world is (default: the file's).");
  group.value("--scale", "S", flags.scale, parse_positive, "Multiply the world coordinates by S.");
  group.choice(
      "--unit", flags.unit, units_of_input(),
      "Unit of the input's world; file is the one that it states, which 'isoextract info' shows. glb and gltf are "
      "written in metres, as glTF prescribes, and other formats in that unit (default: coordinates are written as they "
      "are). Not together with --scale.");
  group.choice("--to-unit", flags.to_unit, units(), "Unit of the mesh, of any format, in place of that; needs --unit.");
  group.flag("--center", flags.center,
             "Move the middle of the samples to the origin: that of --roi where it is given. All surfaces of a volume "
             "move alike.");
}

}  // namespace isoextract::cli

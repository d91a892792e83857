// The options of inputs: the grid or volume to read, its layout, and the field of particles.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "base/enum_words.hpp"
#include "cli/option.hpp"
#include "cli/options/run.hpp"
#include "cli/values.hpp"
#include "convert/conversion_job.hpp"
#include "field/scalar_field.hpp"
#include "points/method.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::cli {

// The side of an iso value that is inside.
enum class InsideChoice { above, below, away_from_zero };
constexpr auto words_of(InsideChoice /*type*/) {
  return std::array{Word{InsideChoice::above, "above"}, Word{InsideChoice::below, "below"},
                    Word{InsideChoice::away_from_zero, "away-from-zero"}};
}

// Returns the values of --input-format: the formats of volume and particle files.
[[nodiscard]] std::vector<Choice<std::string>> input_formats();

// The inputs that a command takes, for its help.
struct InputUse {
  std::string metavar;          // of INPUT
  std::string what;             // the meaning of the inputs: a sentence without a full stop
  bool all_volumes = false;     // takes --volume all, for all volumes of a file
  std::size_t most = SIZE_MAX;  // largest number of inputs
};

struct InputFlags : OptionSet {
  InputFlags(OptionSet& command, InputUse use);

 private:
  InputUse use_;

 public:
  Values<std::string> inputs{*this,
                             "INPUT",
                             use_.metavar,
                             parse_text,
                             use_.what +
                                 ". A path, - for stdin, or demo:NAME (see 'isoextract help demo'). A file named like "
                                 "a command is written ./NAME.",
                             About::anything,
                             use_.most};
  Values<std::string> grids{
      everyday(*this), "--array,--grid", "NAME", parse_text,
      "Grid or array of a file that has several. For VDB, .npz, VTK, HDF5 and other files. 'isoextract info' lists "
      "the names; NAME[k] chooses one of several "
      "grids of the same name. convert takes the option several times: each grid has its own surfaces."};
  Value<VolumeChoice> volume{
      *this, "--volume", use_.all_volumes ? "K|all" : "K", parse_volume,
      std::string("Number of the volume in the file, counted from 0.") +
          (use_.all_volumes ? " all converts each of them." : "") +
          " For files that hold several volumes, such as time steps (NIfTI, NRRD, NPY, netCDF, ...), and for the "
          "frames of a file of particles. 'isoextract info' shows how many there are."};
  Value<volume_io::ComponentChoice> component{
      *this, "--component", "K|length", parse_component,
      "Component of vector samples, or their length. For files with several numbers per sample, such as vectors, "
      "colors and complex numbers; components count from 0. A NumPy array of four axes is then read as [z, y, x, c]."};
  Value<std::uint64_t> level{*this, "--level", "K", parse_count,
                             "Resolution to read, of a file that has several. 0 is the finest (default). For OME-Zarr, "
                             "Imaris and BigDataViewer."};
  Flag resample{
      *this, "--resample",
      "Resample unevenly spaced samples to even spacing. Interpolates linearly. For slices at uneven distances, depths "
      "of an ocean model and rectilinear grids, which isoextract refuses without this option."};
  Value<std::string> format{
      *this, "--input-format", input_formats(),
      "Format of the input (default: found by content). Where the content does not tell, the extension decides."};
  Value<glm::ivec3> dims{*this, "--dims", "NX,NY,NZ", parse_dims,
                         "Samples of a raw file along x, y and z. x varies fastest, unless --axis-order is xyz. "
                         "48x62x42 means the same as 48,62,42."};
  Value<field::SampleType> dtype{*this, "--dtype", "Sample type of a raw file (default: u8).", About::raw_file};
  Value<std::endian> endian{*this,
                            "--endian",
                            {{"little", std::endian::little}, {"big", std::endian::big}},
                            "Byte order of a raw file (default: little).",
                            About::raw_file};
  Value<std::uint64_t> skip{
      *this, "--skip", "BYTES", parse_size, "Bytes before a raw file's first sample (default: 0).", About::raw_file};
  Value<std::uint64_t> components{*this,
                                  "--components",
                                  "N",
                                  parse_components,
                                  "Numbers per sample of a raw file (default: 1). Sample by sample, unless --planar "
                                  "is given. --component chooses one.",
                                  About::raw_file};
  Flag planar{
      *this, "--planar",
      "Components of a raw file lie one after another. Each volume has all samples of the first component, then "
      "those of the second. With --components.",
      About::raw_file};
  Value<volume_io::AxisOrder> axis_order{
      *this, "--axis-order",
      "Axis order of a NumPy array or raw file (default: zyx). The last axis varies fastest, unless the file states "
      "its own order. --dims are along x, y and z in any case."};
  Value<double> no_data{
      *this, "--nodata", "V", parse_number,
      "Value of samples that hold no data. Such samples become NaN, and --nan says what NaN means (default with "
      "--nodata: outside; of terrain: hole). Integer samples become f32, 32-bit integers f64. Not for sparse grids."};
  Value<glm::dvec3> spacing{
      *this, "--spacing", "SX,SY,SZ", parse_spacing,
      "Distance between samples along x, y and z. One number is for all axes. Replaces the file's spacing."};
  Value<glm::dvec3> origin{*this, "--origin", "X,Y,Z", parse_vector,
                           "World position of the first sample. Replaces the file's origin."};
  Value<InsideChoice> inside{
      *this, "--inside",
      "Side of the iso value that is inside. above as in densities, below as in level sets; away-from-zero for fields "
      "of both signs: above a positive iso value, below a negative one. Samples equal to the iso value are outside. "
      "Default: as the file says, otherwise above. info and bench do not take away-from-zero."};
  MemoryLimit memory_limit{*this};
  Flag in_process{*this, "--in-process",
                  "Read plug-in formats without the child process. Plug-ins ('isoextract formats' lists them) "
                  "otherwise read in a child process with limits. Use it only for files that you trust: a damaged file "
                  "can crash the program, hang it, or take more memory than --memory-limit."};

  // Returns the first value of --grid, nullopt without one; more_grids() returns the other values.
  [[nodiscard]] std::optional<std::string> grid() const {
    return grids.empty() ? std::nullopt : std::optional(grids.front());
  }
  [[nodiscard]] std::vector<std::string> more_grids() const {
    return {grids.begin() + (grids.empty() ? 0 : 1), grids.end()};
  }
};

// Returns the methods for the help: "ID: HELP; default iso ISO, cells of SIZE radii. ...", without the last full stop.
[[nodiscard]] std::string particle_methods();

// The options that turn particles into a field.
struct ParticleFlags : OptionSet {
  explicit ParticleFlags(OptionSet& command);

 private:
  convert::ParticleOptions usual_;

 public:
  Value<points::Method> method{
      *this, "--particles",
      fmt::format("Method that makes a field of particles (default: {1}). {0}. Files of particle formats need none of "
                  "these options; an .npy array of N x 3 numbers needs one, such as --particles sph.",
                  particle_methods(), word_of(usual_.method))};
  Value<RadiusChoice> radius{
      everyday(*this), "--radius", "R|auto", parse_radius,
      "Radius of the particles, in the units of the file. Default: auto, the radius of touching particles on a lattice "
      "as dense as the particles. convert gives all frames of a sequence the radius that fits the first frame of 50 or "
      "more particles; auto:each gives each frame its own. An attribute pscale or radius in the file gives each "
      "particle its radius, unless R is given."};
  Value<points::ElementRadii> radii{
      *this, "--radii",
      "Radii of atoms by their element. element: van der Waals radii; covalent: covalent radii. The element is the "
      "attribute species, element or symbol, or follows from the names of the atoms in a .gro file. The radii are in "
      "the unit that --unit of convert or the file states, else in angstrom."};
  Value<double> smoothing_length{*this, "--smoothing-length", "L", parse_positive,
                                 fmt::format("Smoothing length of the kernels, in radii. Kernels reach twice as far, "
                                             "and --particles smooth averages over that distance. Default: {}.",
                                             usual_.smoothing_length)};
  Value<double> cell_size{
      *this, "--cell-size", "C", parse_positive,
      "Distance between samples of the field, in radii. Default: that of the method. With radii from "
      "an attribute, spheres and smooth have up to 4 times closer samples, to keep small particles."};
  Value<double> weight{*this,
                       "--weight",
                       "W",
                       parse_positive,
                       fmt::format("Weight of a particle with --particles weight. Default: {}.", usual_.weight),
                       About::weights};
  Value<points::Deposit> deposit{*this, "--deposit",
                                 fmt::format("Samples that receive a particle's weight. The nearest sample, or the "
                                             "eight samples around it in shares. Default: {}.",
                                             word_of(usual_.deposit)),
                                 About::weights};
  Value<std::array<std::string, 3>> columns{*this, "--columns", "x=A,y=B,z=C", parse_columns,
                                            "Columns of a table that hold x, y and z. By name, or by number counted "
                                            "from 1. Default: as the file names them."};
  Value<std::string> select{
      *this, "--select", "CONDITION", parse_selection,
      "Use only particles that fulfill a condition. Such as 'type == 2 && z > 10'. Names are x, y, z and attributes: "
      "v[0] "
      "or v.x is a component, |v| the length of a vector. Operators: == != < <= > >= + - * /, in {O, H}, in 1..5, and, "
      "or, not, abs, sqrt, min, max. See docs/particles.md."};
  Value<std::string> types{*this, "--type", "T,...", parse_types,
                           "Use only particles of these types. The attribute 'type', as LAMMPS writes it; 1..3 is a "
                           "range. Combines with --select and --species: particles have to fulfill all of them."};
  Value<std::string> species{*this, "--species", "NAME,...", parse_species,
                             "Use only particles of these species. The attribute species, element or symbol, "
                             "whichever the file has; O,H for example."};
  Value<std::uint64_t> stride{*this, "--stride", "N", parse_positive_count,
                              "Use every N-th particle, from the first on. Counts the particles that --select, --type "
                              "and --species choose. The default radius fits the particles that are left."};
  Value<std::array<bool, 3>> periodic{
      *this, "--periodic", "x,y,z", parse_periodic,
      "Edges along which the particles' box is periodic. One or more of x,y,z, or none. In a periodic box the surface "
      "continues from each face to the opposite one and ends at the faces. Default: as the file says."};
  Value<field::Box> box{*this, "--box", "X0,Y0,Z0,X1,Y1,Z1", parse_box,
                        "Box of the simulation: smaller, then larger corner. Periodic along all edges, unless the file "
                        "or --periodic says otherwise. Replaces the file's box."};
  Flag unwrap{
      *this, "--unwrap",
      "Move particles by their image flags (ix, iy, iz). LAMMPS writes them. Bodies that the box cuts are then whole, "
      "and the surface is not periodic."};
};

}  // namespace isoextract::cli

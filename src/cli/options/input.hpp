// The options of inputs: which of a file is read, and how; and how particles become a field.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "base/words.hpp"
#include "cli/option.hpp"
#include "cli/options/run.hpp"
#include "cli/values.hpp"
#include "convert/conversion_job.hpp"
#include "field/scalar_field.hpp"
#include "points/method.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::cli {

// Which side of an iso value is inside.
enum class InsideChoice { above, below, away_from_zero };
constexpr auto words_of(InsideChoice /*type*/) {
  return std::array{Word{InsideChoice::above, "above"}, Word{InsideChoice::below, "below"},
                    Word{InsideChoice::away_from_zero, "away-from-zero"}};
}

// Those of files, of volumes and particles.
[[nodiscard]] std::vector<Choice<std::string>> input_formats();

// What a command does with its inputs.
struct InputUse {
  std::string metavar;          // of INPUT
  std::string what;             // they are for
  bool all_volumes = false;     // --volume all: all volumes of a file are worked through
  std::size_t most = SIZE_MAX;  // inputs
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
                                 ": a path, - for stdin, or demo:NAME (see 'isoextract help demo'). A file that is "
                                 "named like a command is written ./NAME.",
                             About::anything,
                             use_.most};
  Values<std::string> grids{*this, "--grid", "NAME", parse_text,
                            "Grid of a VDB file or array of an .npz, as 'isoextract info' lists it: NAME, or NAME[k] "
                            "where names repeat. A conversion takes several: each has its own surfaces."};
  Value<VolumeChoice> volume{
      *this, "--volume", use_.all_volumes ? "K|all" : "K", parse_volume,
      std::string("Volume of a NIfTI, NRRD, NPY or raw file that holds several, such as time steps, or frame of a file "
                  "of particles: its number, counted from 0") +
          (use_.all_volumes ? ", or each of them" : "") + ". 'isoextract info' tells how many there are."};
  Value<volume_io::ComponentChoice> component{
      *this, "--component", "K|length", parse_component,
      "Of a NIfTI, NRRD or NumPy file with several numbers a sample, such as vectors, colours and complex "
      "numbers: one, counted from 0, or their length. A NumPy array of four axes is then [z, y, x, c]."};
  Value<std::string> format{*this, "--input-format", input_formats(),
                            "Format of the input (default: by content, then by extension)."};
  Value<glm::ivec3> dims{*this, "--dims", "NX,NY,NZ", parse_dims,
                         "Samples along x (fastest), y and z of a raw file. 48x62x42 is the same as 48,62,42."};
  Value<field::SampleType> dtype{*this, "--dtype", "Type of a raw file's samples (default: u8).", About::raw_file};
  Value<std::endian> endian{*this,
                            "--endian",
                            {{"little", std::endian::little}, {"big", std::endian::big}},
                            "Byte order of a raw file's samples (default: little).",
                            About::raw_file};
  Value<std::uint64_t> skip{
      *this, "--skip", "BYTES", parse_size, "Bytes before a raw file's first sample (default: 0).", About::raw_file};
  Value<volume_io::AxisOrder> axis_order{
      *this, "--axis-order",
      "What the axes of a NumPy array or raw file are, the last of them the fastest where the file has no order "
      "of its own (default: zyx). --dims are along x, y and z all the same."};
  Value<double> no_data{
      *this, "--nodata", "V", parse_number,
      "Samples of this value stand for no data: they are not numbers, and --nan says what that means; it is "
      "outside then unless it is given. Integers become f32, those of 32 bits f64. Not of sparse grids."};
  Value<glm::dvec3> spacing{
      *this, "--spacing", "SX,SY,SZ", parse_spacing,
      "Distance of the samples along each axis, or one number for all; replaces what the file says."};
  Value<glm::dvec3> origin{*this, "--origin", "X,Y,Z", parse_vector,
                           "World position of the first sample; replaces what the file says."};
  Value<InsideChoice> inside{
      *this, "--inside",
      "Which side of an iso value is inside: above as in densities, below as in level sets (default: as the file says, "
      "else above), or away-from-zero for fields of both signs: above a positive iso value, below a negative one. A "
      "value equal to the iso value is outside."};
  MemoryLimit memory_limit{*this};
  Flag in_process{
      *this, "--in-process",
      "Read files of plug-ins (VTK, OpenVDB's points and vectors) in the program's own process, not in a child process "
      "with limits. Only for files that you trust: a damaged one can crash the program, hang it, or take more memory "
      "than --memory-limit."};

  // The first of the grids.
  [[nodiscard]] std::optional<std::string> grid() const {
    return grids.empty() ? std::nullopt : std::optional(grids.front());
  }
  [[nodiscard]] std::vector<std::string> more_grids() const {
    return {grids.begin() + (grids.empty() ? 0 : 1), grids.end()};
  }
};

// "weight (a fixed weight for each particle), sph (...)"
[[nodiscard]] std::string particle_methods();

// How particles become a field.
struct ParticleFlags : OptionSet {
  explicit ParticleFlags(OptionSet& command);

 private:
  convert::ParticleOptions usual_;

 public:
  Value<points::Method> method{
      *this, "--particles",
      fmt::format("The input is particles, and becomes a field by {} (default: {}). Files that can only be particles "
                  "need no option; an NPY array of N rows does.",
                  particle_methods(), word_of(usual_.method))};
  Value<double> radius{
      *this, "--radius", "R", parse_positive,
      "Radius of a particle, in the units of the file (default: half the median distance to the nearest one, of each "
      "file by itself; give one for a sequence). With --particles spheres and smooth each particle has its own by "
      "default where the file has an attribute pscale or radius."};
  Value<double> smoothing_length{
      *this, "--smoothing-length", "L", parse_positive,
      fmt::format("Smoothing length of the kernels, in radii; they reach twice as far, as do the particles that "
                  "--particles smooth averages (default: {}).",
                  usual_.smoothing_length)};
  Value<double> cell_size{*this, "--cell-size", "C", parse_positive,
                          "Distance of the field's samples, in radii (default: that of the method)."};
  Value<double> weight{*this,
                       "--weight",
                       "W",
                       parse_positive,
                       fmt::format("What a particle adds with --particles weight (default: {}).", usual_.weight),
                       About::weights};
  Value<points::Deposit> deposit{
      *this, "--deposit",
      fmt::format("Where that goes: to the nearest sample, or shared among the eight around (default: {}).",
                  word_of(usual_.deposit)),
      About::weights};
  Value<std::array<std::string, 3>> columns{
      *this, "--columns", "x=A,y=B,z=C", parse_columns,
      "Which columns of a table are x, y and z: their names, or their numbers counted from 1 (default: as the file "
      "names them)."};
};

}  // namespace isoextract::cli

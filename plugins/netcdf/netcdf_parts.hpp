// Shared by the files of the netCDF plug-in.
//
// The rules for axes and missing values are those of the CF conventions 1.8, sections 2.5, 4, 5 and 8.1
// (https://cfconventions.org), and of the attribute conventions of the NetCDF User's Guide.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <netcdf.h>

#include <volume_reader.hpp>

namespace isoextract_netcdf {

using isoextract_plugin::Grid;
using isoextract_plugin::HostMemory;
using isoextract_plugin::ReadError;
using isoextract_plugin::ReadFacts;
using isoextract_plugin::UnevenError;

// Throws with the library's reason unless the status is a success.
void check(int status, const std::string& what);

// Returns a number for messages: "0.25", "5000".
std::string number_text(double value);

// Checks the header of a classic file (CDF-1, -2 and -5) against the file's size: the library trusts the header, and
// reads zeros beyond the end of a cut file. Throws ReadError if the header is damaged or samples are missing.
void check_classic_header(const std::string& path);

// Returns a text attribute; "" if there is none, or it has several texts or more than 4,096 characters. The variable is
// NC_GLOBAL for attributes of the group.
std::string text_attribute(int group, int variable, const char* name);
// Returns the numbers of an attribute; empty if there is none, it has a text, or more than 4,096 numbers.
std::vector<double> number_attribute(int group, int variable, const char* name);

enum class Role { x, y, z, time, unknown };

// A dimension with its coordinate variable.
struct Axis {
  std::string name;
  std::uint64_t length = 0;
  Role role = Role::unknown;
  std::string unit;                 // as in the file
  std::vector<double> coordinates;  // unpacked; longitudes without jumps by 360 degrees; empty if none or over 2^20
  bool points_down = false;         // coordinates increase downwards

  // first() and step() return the start and the slope of the straight line from the first coordinate to the last; 0 and
  // 1 without coordinates.
  [[nodiscard]] double first() const { return coordinates.empty() ? 0 : coordinates.front(); }
  [[nodiscard]] double step() const;
  // Returns whether that line meets every coordinate, within a thousandth of a step or the rounding of 32-bit floats;
  // true without coordinates.
  [[nodiscard]] bool is_even() const;
  [[nodiscard]] bool is_monotonic() const;
  // Returns the least and the greatest distance of neighboring coordinates.
  [[nodiscard]] std::array<double, 2> distances() const;
};

// Reads a dimension that is visible in the group.
Axis read_axis(int group, int dimension);

// Positions of new samples between old samples: new sample i is (1 - weight[i]) * old[lower[i]] + weight[i] *
// old[lower[i] + 1].
struct Resampling {
  std::vector<std::uint64_t> lower;
  std::vector<double> weight;
  double step = 0;
};

// Returns evenly spaced samples from the first to the last coordinate, at most as far apart as the closest old samples;
// farther apart if that needs more than `most_samples`. Needs a monotonic axis.
Resampling even_out(const Axis& axis, std::uint64_t most_samples);

// Stored values that mean "no data": `values`, and all outside `least` to `greatest`.
struct MissingValues {
  std::vector<double> values;
  double least = -std::numeric_limits<double>::infinity();
  double greatest = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool any() const {
    return !values.empty() || least > -std::numeric_limits<double>::infinity() ||
           greatest < std::numeric_limits<double>::infinity();
  }
};

// A variable as a grid. The grid's axes are the spatial dimensions in reverse order: the last is grid axis 0, the
// fastest.
struct Variable {
  int group = 0;
  int id = 0;
  nc_type type = NC_NAT;
  double unsigned_range = 0;  // added to negative values of signed types that hold unsigned numbers; else 0
  std::vector<std::uint64_t> shape;
  std::array<std::size_t, 3> dimension{};      // of each grid axis
  std::vector<std::size_t> volume_dimensions;  // all other dimensions, in the file's order
  std::array<Axis, 3> axes;
  std::array<Resampling, 3> resampling;  // empty where none is needed
  MissingValues missing;
  std::string problem;     // why the variable cannot be read; empty if it can
  bool is_uneven = false;  // the problem is uneven spacing
  std::string note;        // for the user: placement, resampling, rounded 64-bit integers
};

// Describes a variable. Returns false if it has fewer than three dimensions.
bool describe_variable(int group, int id, const std::string& name, bool resamples, Variable& variable, Grid& grid);

// Fills selection.box.
ReadFacts read_variable(const Variable& variable, const Grid& grid, const isoextract_volume_selection& selection,
                        const isoextract_plugin_host& host);

}  // namespace isoextract_netcdf

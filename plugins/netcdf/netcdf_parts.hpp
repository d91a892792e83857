// The parts of the plug-in around netCDF.
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

// Checks the header of a classic file (CDF-1, -2 and -5) against the file's size: the library trusts it, and reads
// zeros after the end of a file that was cut. Throws if the header is damaged or samples are missing.
void check_classic_header(const std::string& path);

// Returns a text attribute; "" if there is none. The variable is NC_GLOBAL for attributes of the group.
std::string text_attribute(int group, int variable, const char* name);
// Returns the numbers of an attribute; empty if there is none or it has a text.
std::vector<double> number_attribute(int group, int variable, const char* name);

enum class Role { x, y, z, time, unknown };

// A dimension with its coordinate variable.
struct Axis {
  std::string name;
  std::uint64_t length = 0;
  Role role = Role::unknown;
  std::string unit;                 // as in the file
  std::vector<double> coordinates;  // as in the file, longitudes continued past 360 degrees; empty if there are none
  bool points_down = false;         // coordinates increase downwards

  // Returns the start of the straight line from the first coordinate to the last; step() returns its slope.
  [[nodiscard]] double first() const { return coordinates.empty() ? 0 : coordinates.front(); }
  [[nodiscard]] double step() const;
  // Whether that line meets every coordinate, within a thousandth of a step or the rounding of 32-bit floats.
  [[nodiscard]] bool is_even() const;
  [[nodiscard]] bool is_monotonic() const;
  // Returns the least and the greatest distance of neighbors.
  [[nodiscard]] std::array<double, 2> distances() const;
};

// Reads a dimension that is visible in the group.
Axis read_axis(int group, int dimension);

// Positions of new samples between old ones: new sample i is (1 - weight[i]) * old[lower[i]] + weight[i] *
// old[lower[i] + 1].
struct Resampling {
  std::vector<std::uint64_t> lower;
  std::vector<double> weight;
  double step = 0;
};

// Returns evenly spaced samples from the first to the last coordinate, as far apart as the closest old ones, but at
// most `most_samples`. The axis is monotonic.
Resampling even_out(const Axis& axis, std::uint64_t most_samples);

// Stored values that mean "no data".
struct MissingValues {
  std::vector<double> values;
  double least = -std::numeric_limits<double>::infinity();
  double greatest = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool any() const {
    return !values.empty() || least > -std::numeric_limits<double>::infinity() ||
           greatest < std::numeric_limits<double>::infinity();
  }
};

// A variable as a grid. Grid axes are its spatial dimensions in reverse order: the last dimension is x, the fastest.
struct Variable {
  int group = 0;
  int id = 0;
  nc_type type = NC_NAT;
  double unsigned_range = 0;  // added to negative values of signed types that hold unsigned numbers; else 0
  std::vector<std::uint64_t> shape;
  std::array<std::size_t, 3> dimension{};      // of each grid axis
  std::vector<std::size_t> volume_dimensions;  // in the file's order
  std::array<Axis, 3> axes;
  std::array<Resampling, 3> resampling;  // empty where none is needed
  MissingValues missing;
  std::string problem;     // why it cannot be read; empty if it can
  bool is_uneven = false;  // the problem is uneven spacing
  std::string note;        // assumptions of its placement
};

// Describes a variable. Returns false if it has fewer than three dimensions.
bool describe_variable(int group, int id, const std::string& name, bool resamples, Variable& variable, Grid& grid);

// Fills selection.box.
ReadFacts read_variable(const Variable& variable, const Grid& grid, const isoextract_volume_selection& selection,
                        const isoextract_plugin_host& host);

}  // namespace isoextract_netcdf

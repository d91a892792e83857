#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "netcdf_parts.hpp"

namespace isoextract_netcdf {
namespace {

// A resampled axis may grow by kMostGrowth, and always up to this many samples in the grid: 512 MiB of 32-bit floats.
constexpr std::uint64_t kResampledSamples = std::uint64_t{1} << 27;
constexpr std::uint64_t kMostGrowth = 4;

const char* type_name(nc_type type) {
  switch (type) {
    case NC_BYTE: return "byte";
    case NC_UBYTE: return "unsigned byte";
    case NC_CHAR: return "char";
    case NC_SHORT: return "short";
    case NC_USHORT: return "unsigned short";
    case NC_INT: return "int";
    case NC_UINT: return "unsigned int";
    case NC_INT64: return "int64";
    case NC_UINT64: return "unsigned int64";
    case NC_FLOAT: return "float";
    case NC_DOUBLE: return "double";
    case NC_STRING: return "string";
    default: return "user-defined type";
  }
}

// Returns the library's value of unwritten samples; nothing for bytes and text, where it may be a written value.
std::optional<double> default_fill(nc_type type) {
  switch (type) {
    case NC_SHORT: return NC_FILL_SHORT;
    case NC_USHORT: return NC_FILL_USHORT;
    case NC_INT: return NC_FILL_INT;
    case NC_UINT: return NC_FILL_UINT;
    case NC_INT64: return static_cast<double>(NC_FILL_INT64);
    case NC_UINT64: return static_cast<double>(NC_FILL_UINT64);
    case NC_FLOAT: return static_cast<double>(NC_FILL_FLOAT);
    case NC_DOUBLE: return NC_FILL_DOUBLE;
    default: return std::nullopt;
  }
}

double unsigned_range(int group, int id, nc_type type) {
  std::string text = text_attribute(group, id, "_Unsigned");
  if (text != "true" && text != "True" && text != "TRUE") return 0;
  return type == NC_BYTE ? 0x1p8 : type == NC_SHORT ? 0x1p16 : type == NC_INT ? 0x1p32 : 0;
}

MissingValues missing_values(const Variable& variable, double slope, double intercept) {
  MissingValues missing;
  const auto numbers = [&](const char* name) {
    auto found = number_attribute(variable.group, variable.id, name);
    for (double& value : found) {
      if (value < 0) value += variable.unsigned_range;
    }
    return found;
  };
  // CF 1.8, 2.5.1: limits of floating type for samples of integer type apply to the unpacked values.
  const auto limit = [&](const char* name, std::size_t index) -> std::optional<double> {
    auto found = numbers(name);
    if (found.size() <= index) return std::nullopt;
    nc_type type = NC_NAT;
    const bool known = nc_inq_atttype(variable.group, variable.id, name, &type) == NC_NOERR;
    const bool is_unpacked = known && (type == NC_FLOAT || type == NC_DOUBLE) && variable.type != NC_FLOAT &&
                             variable.type != NC_DOUBLE && slope > 0;
    return is_unpacked ? (found[index] - intercept) / slope : found[index];
  };
  missing.values = numbers("_FillValue");
  if (missing.values.empty()) {
    if (const auto fill = default_fill(variable.type)) missing.values.push_back(*fill);
  }
  const auto more = numbers("missing_value");
  missing.values.insert(missing.values.end(), more.begin(), more.end());
  if (const auto found = limit("valid_min", 0)) missing.least = *found;
  if (const auto found = limit("valid_max", 0)) missing.greatest = *found;
  if (const auto found = limit("valid_range", 1)) {
    missing.least = *limit("valid_range", 0);
    missing.greatest = *found;
  }
  return missing;
}

// Missing values become NaN, which integers do not have.
std::int32_t sample_type(const Variable& variable, bool needs_floats) {
  switch (variable.type) {
    case NC_BYTE:
    case NC_UBYTE:
      if (needs_floats) return ISOEXTRACT_F32;
      return variable.type == NC_UBYTE || variable.unsigned_range > 0 ? ISOEXTRACT_U8 : ISOEXTRACT_I8;
    case NC_SHORT:
    case NC_USHORT:
    case NC_FLOAT: return ISOEXTRACT_F32;
    case NC_INT:
    case NC_UINT:
    case NC_INT64:
    case NC_UINT64:
    case NC_DOUBLE: return ISOEXTRACT_F64;
    default: return ISOEXTRACT_NOT_SCALAR;
  }
}

// Returns the dimensions of the grid axes x, y and z, the last dimension first. Of more than three, prefers dimensions
// with a spatial role, then unknown ones, then time; among equals the last.
std::array<std::size_t, 3> choose_dimensions(const std::vector<Axis>& dimensions) {
  std::vector<std::size_t> order(dimensions.size());
  std::iota(order.rbegin(), order.rend(), std::size_t{0});
  if (order.size() > 3) {
    const auto rank = [&](std::size_t i) {
      return dimensions[i].role == Role::time ? 2 : dimensions[i].role == Role::unknown ? 1 : 0;
    };
    std::ranges::stable_sort(order, {}, rank);
    order.resize(3);
    std::ranges::sort(order, std::greater());
  }
  return {order[0], order[1], order[2]};
}

// Returns the world axis of each grid axis.
std::array<std::size_t, 3> world_axes(const std::array<Axis, 3>& axes) {
  constexpr std::size_t kNone = 3;
  std::array<std::size_t, 3> world{kNone, kNone, kNone};
  std::array<bool, 3> taken{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Role role = axes[axis].role;
    if (role != Role::x && role != Role::y && role != Role::z) continue;
    const auto wanted = static_cast<std::size_t>(role);
    if (taken[wanted]) continue;
    taken[wanted] = true;
    world[axis] = wanted;
  }
  for (std::size_t& axis : world) {
    if (axis != kNone) continue;
    axis = static_cast<std::size_t>(std::ranges::find(taken, false) - taken.begin());
    taken[axis] = true;
  }
  return world;
}

std::string axis_text(const Axis& axis) {
  std::string text = axis.points_down ? "-" + axis.name : axis.name;
  if (axis.coordinates.empty()) return text + " (no coordinates: counted from 0)";
  return text + (axis.unit.empty() ? " (no unit)" : " (" + axis.unit + ")");
}

std::string distances_text(const Axis& axis) {
  const auto [least, greatest] = axis.distances();
  return number_text(least) + " to " + number_text(greatest) + (axis.unit.empty() ? "" : " " + axis.unit);
}

// Sets the grid's dimensions and placement, and the note about them; resamples uneven axes if `resamples`.
void place(Variable& variable, Grid& grid, bool resamples) {
  std::array<std::uint64_t, 3> dims{};
  for (std::size_t axis = 0; axis < 3; ++axis) dims[axis] = variable.axes[axis].length;
  const auto world = world_axes(variable.axes);
  grid.index_to_world.fill(0);
  grid.has_placement = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Axis& along = variable.axes[axis];
    double step = along.step();
    if (!along.is_even()) {
      const std::string found =
          "its axis " + along.name + " has uneven distances: expected equal ones, found " + distances_text(along);
      if (!along.is_monotonic()) {
        variable.problem = "its axis " + along.name + " neither increases nor decreases throughout";
        step = 1;
      } else if (!resamples) {
        variable.problem = found;
        variable.is_uneven = true;
      } else {
        const double others = static_cast<double>(dims[0]) * static_cast<double>(dims[1]) *
                              static_cast<double>(dims[2]) / static_cast<double>(dims[axis]);
        const auto most = static_cast<std::uint64_t>(static_cast<double>(kResampledSamples) / std::max(others, 1.0));
        variable.resampling[axis] = even_out(along, std::max(kMostGrowth * along.length, most));
        step = variable.resampling[axis].step;
        dims[axis] = variable.resampling[axis].lower.size();
        variable.note += "the reader resamples axis " + along.name + " linearly from " + std::to_string(along.length) +
                         " samples, " + distances_text(along) + " apart, to " + std::to_string(dims[axis]) +
                         " samples, " + number_text(std::abs(step)) + " apart; ";
      }
    }
    const double sign = along.points_down ? -1 : 1;
    grid.index_to_world[4 * world[axis] + axis] = sign * step;
    grid.index_to_world[4 * world[axis] + 3] = sign * along.first() + 0.0;  // never -0
    grid.has_placement = grid.has_placement || !along.coordinates.empty();
  }
  grid.dims = dims;
  if (!grid.has_placement) return;
  std::array<std::string, 3> texts;
  for (std::size_t axis = 0; axis < 3; ++axis) texts[world[axis]] = axis_text(variable.axes[axis]);
  variable.note += "x is " + texts[0] + ", y is " + texts[1] + ", z is " + texts[2];
  const auto& unit = variable.axes[0].unit;
  const bool same = unit == variable.axes[1].unit && unit == variable.axes[2].unit;
  if (!same) variable.note += "; the units of the axes differ";
  if (same && unit.find("degree") == std::string::npos) grid.length_unit = unit;
}

void describe_volumes(Variable& variable, const std::vector<Axis>& dimensions, Grid& grid) {
  const Axis* time = nullptr;
  std::size_t long_ones = 0;
  for (std::size_t i = 0; i < dimensions.size(); ++i) {
    if (std::ranges::find(variable.dimension, i) != variable.dimension.end()) continue;
    variable.volume_dimensions.push_back(i);
    if (__builtin_mul_overflow(grid.volumes, dimensions[i].length, &grid.volumes))
      throw ReadError("its variable " + grid.name + " has more than 2^64 samples");
    if (dimensions[i].length > 1) ++long_ones;
    if (dimensions[i].length > 1 || time == nullptr) time = &dimensions[i];
  }
  if (time == nullptr || long_ones > 1) return;
  grid.volume_times = time->coordinates;
  grid.time_unit = time->unit;
}

}  // namespace

bool describe_variable(int group, int id, const std::string& name, bool resamples, Variable& variable, Grid& grid) {
  int rank = 0;
  check(nc_inq_varndims(group, id, &rank), "netCDF cannot read its variable " + name);
  if (rank < 3) return false;
  variable.group = group;
  variable.id = id;
  check(nc_inq_vartype(group, id, &variable.type), "netCDF cannot read its variable " + name);
  std::vector<int> ids(static_cast<std::size_t>(rank));
  check(nc_inq_vardimid(group, id, ids.data()), "netCDF cannot read its variable " + name);
  std::vector<Axis> dimensions;
  for (const int dimension : ids) dimensions.push_back(read_axis(group, dimension));
  for (const Axis& axis : dimensions) variable.shape.push_back(axis.length);
  variable.dimension = choose_dimensions(dimensions);
  for (std::size_t axis = 0; axis < 3; ++axis) variable.axes[axis] = dimensions[variable.dimension[axis]];

  grid.name = name;
  grid.type_name = type_name(variable.type);
  describe_volumes(variable, dimensions, grid);
  if (std::ranges::find(variable.shape, 0U) != variable.shape.end()) {
    variable.problem = "its variable " + name + " has no samples";
    grid.type_name += " without samples";
    return true;
  }
  const auto scale = number_attribute(group, id, "scale_factor");
  const auto offset = number_attribute(group, id, "add_offset");
  if (!scale.empty()) grid.slope = scale[0];
  if (!offset.empty()) grid.intercept = offset[0];
  variable.unsigned_range = unsigned_range(group, id, variable.type);
  variable.missing = missing_values(variable, grid.slope, grid.intercept);
  place(variable, grid, resamples);
  const bool is_resampled =
      std::ranges::any_of(variable.resampling, [](const Resampling& r) { return !r.lower.empty(); });
  grid.sample_type = sample_type(variable, variable.missing.any() || is_resampled);
  if (variable.type == NC_INT64 || variable.type == NC_UINT64)
    variable.note += "; the reader makes doubles of 64-bit integers, exact up to 2^53";
  return true;
}

}  // namespace isoextract_netcdf

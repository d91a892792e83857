#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <optional>

#include "netcdf_parts.hpp"

namespace isoextract_netcdf {
namespace {

// Attributes that describe axes and missing values are short.
constexpr std::size_t kMostItems = 4096;

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_one_of(const std::string& text, std::initializer_list<const char*> words) {
  return std::ranges::any_of(words, [&](const char* word) { return text == word; });
}

bool is_pressure(const std::string& unit) {
  return is_one_of(unit, {"pa", "hpa", "kpa", "mb", "mbar", "millibar", "millibars", "bar", "dbar", "decibar",
                          "decibars", "pascal", "pascals", "atm", "atmosphere"});
}

Role role_by_attributes(const std::string& axis, const std::string& unit, const std::string& standard_name,
                        const std::string& positive) {
  if (axis == "x") return Role::x;
  if (axis == "y") return Role::y;
  if (axis == "z") return Role::z;
  if (axis == "t") return Role::time;
  if (is_one_of(unit, {"degrees_east", "degree_east", "degree_e", "degrees_e", "degreee", "degreese"})) return Role::x;
  if (is_one_of(unit, {"degrees_north", "degree_north", "degree_n", "degrees_n", "degreen", "degreesn"}))
    return Role::y;
  if (unit.find(" since ") != std::string::npos) return Role::time;
  if (is_one_of(standard_name, {"longitude", "projection_x_coordinate", "grid_longitude"})) return Role::x;
  if (is_one_of(standard_name, {"latitude", "projection_y_coordinate", "grid_latitude"})) return Role::y;
  if (is_one_of(standard_name, {"time", "forecast_reference_time", "forecast_period"})) return Role::time;
  if (is_one_of(standard_name, {"depth", "height", "altitude", "air_pressure", "geopotential_height"})) return Role::z;
  if (is_one_of(positive, {"up", "down"}) || is_pressure(unit)) return Role::z;
  return Role::unknown;
}

Role role_by_name(const std::string& name) {
  if (is_one_of(name, {"x", "lon", "longitude", "easting"})) return Role::x;
  if (is_one_of(name, {"y", "lat", "latitude", "northing"})) return Role::y;
  if (is_one_of(name, {"z", "lev", "level", "plev", "depth", "height", "altitude", "elevation"})) return Role::z;
  if (is_one_of(name, {"t", "time"})) return Role::time;
  return Role::unknown;
}

// Finds the one-dimensional variable with the dimension's name, in the group or a parent group.
std::optional<std::array<int, 2>> find_coordinates(int group, const std::string& name, int dimension) {
  for (;;) {
    int id = 0;
    int rank = 0;
    int dimension_found = 0;
    if (nc_inq_varid(group, name.c_str(), &id) == NC_NOERR) {
      const bool fits = nc_inq_varndims(group, id, &rank) == NC_NOERR && rank == 1 &&
                        nc_inq_vardimid(group, id, &dimension_found) == NC_NOERR && dimension_found == dimension;
      if (fits) return std::array{group, id};
      return std::nullopt;
    }
    if (nc_inq_grp_parent(group, &group) != NC_NOERR) return std::nullopt;
  }
}

}  // namespace

void check(int status, const std::string& what) {
  if (status != NC_NOERR) throw ReadError(what + ": " + nc_strerror(status));
}

std::string number_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.7g", value);
  return text.data();
}

std::string text_attribute(int group, int variable, const char* name) {
  nc_type type = NC_NAT;
  std::size_t length = 0;
  if (nc_inq_att(group, variable, name, &type, &length) != NC_NOERR || length > kMostItems) return {};
  if (type == NC_CHAR) {
    std::string text(length, '\0');
    if (nc_get_att_text(group, variable, name, text.data()) != NC_NOERR) return {};
    return text.substr(0, text.find('\0'));
  }
  if (type != NC_STRING || length != 1) return {};
  char* text = nullptr;
  if (nc_get_att_string(group, variable, name, &text) != NC_NOERR || text == nullptr) return {};
  std::string copy(text);
  nc_free_string(1, &text);
  return copy;
}

std::vector<double> number_attribute(int group, int variable, const char* name) {
  nc_type type = NC_NAT;
  std::size_t length = 0;
  if (nc_inq_att(group, variable, name, &type, &length) != NC_NOERR || length > kMostItems) return {};
  if (type == NC_CHAR || type == NC_STRING || type > NC_MAX_ATOMIC_TYPE) return {};
  std::vector<double> numbers(length);
  if (nc_get_att_double(group, variable, name, numbers.data()) != NC_NOERR) return {};
  return numbers;
}

double Axis::step() const {
  if (coordinates.size() < 2) return 1;
  return (coordinates.back() - coordinates.front()) / static_cast<double>(coordinates.size() - 1);
}

bool Axis::is_even() const {
  double largest = 0;
  double deviation = 0;
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    largest = std::max(largest, std::abs(coordinates[i]));
    deviation = std::max(deviation, std::abs(coordinates[i] - (first() + static_cast<double>(i) * step())));
  }
  const double rounding = std::min(largest * 2e-7, std::abs(step()) / 4);
  return coordinates.empty() || (step() != 0 && deviation <= std::max(std::abs(step()) * 1e-3, rounding));
}

bool Axis::is_monotonic() const {
  for (std::size_t i = 1; i < coordinates.size(); ++i) {
    const double distance = coordinates[i] - coordinates[i - 1];
    if (!std::isfinite(distance) || distance == 0 || (distance > 0) != (step() > 0)) return false;
  }
  return true;
}

std::array<double, 2> Axis::distances() const {
  std::array<double, 2> found{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t i = 1; i < coordinates.size(); ++i) {
    const double distance = std::abs(coordinates[i] - coordinates[i - 1]);
    found = {std::min(found[0], distance), std::max(found[1], distance)};
  }
  return found;
}

Axis read_axis(int group, int dimension) {
  Axis axis;
  std::array<char, NC_MAX_NAME + 1> name{};
  std::size_t length = 0;
  check(nc_inq_dim(group, dimension, name.data(), &length), "netCDF cannot read its dimension");
  axis.name = name.data();
  axis.length = length;
  const auto variable = find_coordinates(group, axis.name, dimension);
  if (!variable) {
    axis.role = role_by_name(lower_case(axis.name));
    return axis;
  }
  const auto [where, id] = *variable;
  axis.unit = text_attribute(where, id, "units");
  const std::string unit = lower_case(axis.unit);
  const std::string positive = lower_case(text_attribute(where, id, "positive"));
  axis.role = role_by_attributes(lower_case(text_attribute(where, id, "axis")), unit,
                                 lower_case(text_attribute(where, id, "standard_name")), positive);
  if (axis.role == Role::unknown) axis.role = role_by_name(lower_case(axis.name));
  axis.points_down = axis.role == Role::z && (positive == "down" || (positive != "up" && is_pressure(unit)));

  nc_type type = NC_NAT;
  check(nc_inq_vartype(where, id, &type), "netCDF cannot read its axis " + axis.name);
  constexpr std::size_t kMostCoordinates = std::size_t{1} << 20;
  if (type == NC_CHAR || type >= NC_STRING || length == 0 || length > kMostCoordinates) return axis;
  axis.coordinates.resize(length);
  check(nc_get_var_double(where, id, axis.coordinates.data()), "netCDF cannot read its axis " + axis.name);
  const auto scale = number_attribute(where, id, "scale_factor");
  const auto offset = number_attribute(where, id, "add_offset");
  for (double& value : axis.coordinates) {
    if (!scale.empty()) value *= scale[0];
    if (!offset.empty()) value += offset[0];
  }
  if (axis.role == Role::x && unit.starts_with("degree")) {
    for (std::size_t i = 1; i < length; ++i) {
      double& value = axis.coordinates[i];
      const double distance = value - axis.coordinates[i - 1];
      if (std::abs(distance) > 180 && std::isfinite(distance)) value -= 360 * std::round(distance / 360);
    }
  }
  return axis;
}

Resampling even_out(const Axis& axis, std::uint64_t most_samples) {
  const auto& at = axis.coordinates;
  const double range = at.back() - at.front();
  const double wanted = std::ceil(std::abs(range) / axis.distances()[0] - 1e-6) + 1;
  const std::uint64_t count =
      wanted < static_cast<double>(most_samples) ? static_cast<std::uint64_t>(wanted) : most_samples;
  Resampling result;
  result.step = range / static_cast<double>(count - 1);
  result.lower.resize(count);
  result.weight.resize(count);
  std::size_t below = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const double position = i + 1 == count ? range : static_cast<double>(i) * result.step;
    while (below + 2 < at.size() && std::abs(at[below + 1] - at.front()) <= std::abs(position)) ++below;
    const double weight = (position - (at[below] - at.front())) / (at[below + 1] - at[below]);
    // A new sample at the position of an old one keeps its value, even if the old one's neighbor is missing (NaN).
    constexpr double kRounding = 1e-9;
    result.lower[i] = below;
    result.weight[i] = weight < kRounding ? 0 : weight > 1 - kRounding ? 1 : weight;
  }
  return result;
}

}  // namespace isoextract_netcdf

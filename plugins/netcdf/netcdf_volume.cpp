// netCDF files of all versions, through the netCDF library.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <set>

#include "netcdf_parts.hpp"

namespace {

using namespace isoextract_netcdf;  // NOLINT(google-build-using-namespace): all of this file is of it

// Serializes all calls, because the library is not thread-safe.
std::recursive_mutex& library_mutex() {
  static std::recursive_mutex mutex;
  return mutex;
}

bool is_classic(const char* start, std::size_t bytes) {
  return bytes >= 4 && std::equal(start, start + 3, "CDF") && (start[3] == 1 || start[3] == 2 || start[3] == 5);
}

const char* format_name(int format) {
  switch (format) {
    case NC_FORMAT_CLASSIC: return "netCDF classic";
    case NC_FORMAT_64BIT_OFFSET: return "netCDF 64-bit offset";
    case NC_FORMAT_64BIT_DATA: return "netCDF CDF-5";
    case NC_FORMAT_NETCDF4_CLASSIC: return "netCDF-4 classic model";
    default: return "netCDF-4";
  }
}

class OpenFile {
 public:
  explicit OpenFile(const std::string& path) {
    check(nc_open(path.c_str(), NC_NOWRITE, &id_), "netCDF cannot open it");
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    const std::scoped_lock lock(library_mutex());
    nc_close(id_);
  }
  [[nodiscard]] int id() const { return id_; }

 private:
  int id_ = 0;
};

// Returns the names of variables that hold the cell bounds of other variables; the list leaves them out.
std::set<std::string> bounds_variables(int group, int count) {
  std::set<std::string> names;
  for (int id = 0; id < count; ++id) {
    for (const char* attribute : {"bounds", "edges", "climatology"}) names.insert(text_attribute(group, id, attribute));
  }
  return names;
}

class NetcdfFile final : public isoextract_plugin::VolumeFile {
 public:
  NetcdfFile(const isoextract_plugin::Request& request, const isoextract_plugin_host& host)
      : file_(request.path), resamples_(request.resamples) {
    int kind = 0;
    check(nc_inq_format(file_.id(), &kind), "netCDF cannot read its format");
    format = format_name(kind);
    list_group(file_.id(), "", host);
    if (grids.empty()) throw ReadError("expected a variable of three or more dimensions, found none");
    for (std::size_t i = 0; i < grids.size(); ++i) {
      if (!variables_[i].problem.empty() && note.empty()) note = grids[i].name + ": " + variables_[i].problem;
    }
  }

  isoextract_plugin::ReadFacts read(const isoextract_volume_selection& selection,
                                    const isoextract_plugin_host& host) override {
    const std::scoped_lock lock(library_mutex());
    return read_variable(variables_[selection.grid], grids[selection.grid], selection, host);
  }

 private:
  // `path` is "" for the root, whose variables have plain names; else it begins and ends with a slash.
  void list_group(int group, const std::string& path, const isoextract_plugin_host& host) {
    isoextract_plugin::check_cancelled(host);
    int count = 0;
    check(nc_inq_nvars(group, &count), "netCDF cannot list its variables");
    const auto skipped = bounds_variables(group, count);
    for (int id = 0; id < count; ++id) {
      std::array<char, NC_MAX_NAME + 1> name{};
      check(nc_inq_varname(group, id, name.data()), "netCDF cannot list its variables");
      if (skipped.contains(name.data())) continue;
      Variable variable;
      isoextract_plugin::Grid grid;
      if (!describe_variable(group, id, path + name.data(), resamples_, variable, grid)) continue;
      variables_.push_back(std::move(variable));
      grids.push_back(std::move(grid));
    }
    int groups = 0;
    check(nc_inq_grps(group, &groups, nullptr), "netCDF cannot list its groups");
    std::vector<int> ids(static_cast<std::size_t>(groups));
    check(nc_inq_grps(group, &groups, ids.data()), "netCDF cannot list its groups");
    for (const int id : ids) {
      std::array<char, NC_MAX_NAME + 1> name{};
      check(nc_inq_grpname(id, name.data()), "netCDF cannot list its groups");
      list_group(id, (path.empty() ? "/" : path) + name.data() + "/", host);
    }
  }

  OpenFile file_;
  bool resamples_;
  std::vector<Variable> variables_;
};

std::unique_ptr<isoextract_plugin::VolumeFile> open_file(const isoextract_plugin::Request& request,
                                                         const isoextract_plugin_host& host) {
  std::array<char, 4> start{};
  std::ifstream(request.path, std::ios::binary).read(start.data(), start.size());
  if (is_classic(start.data(), start.size())) check_classic_header(request.path);
  const std::scoped_lock lock(library_mutex());
  // Stops HDF5, on which netCDF-4 is built, from loading filters from folders: they would be foreign code.
  ::setenv("HDF5_PLUGIN_PRELOAD", "::", 1);
  return std::make_unique<NetcdfFile>(request, host);
}

bool probe_file(const unsigned char* start, std::size_t bytes, const std::string& path) {
  std::array<char, 8> text{};
  std::copy_n(start, std::min(bytes, text.size()), text.data());
  if (is_classic(text.data(), bytes)) return true;
  // netCDF-4 files are HDF5 files; only the file name distinguishes them.
  const bool is_hdf5 = bytes >= 8 && std::equal(text.begin(), text.end(), "\x89HDF\r\n\x1a\n");
  return is_hdf5 && (path.ends_with(".nc") || path.ends_with(".nc4") || path.ends_with(".cdf"));
}

}  // namespace

const isoextract_volume_plugin_v4* isoextract_volume_plugin() {
  static const isoextract_volume_plugin_v4 table =
      isoextract_plugin::volume_plugin<open_file, probe_file>("netcdf", "netCDF");
  return &table;
}

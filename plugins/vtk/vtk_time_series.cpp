// Time steps in separate files: ParaView's .pvd and .series (JSON). Steps may have different boxes and formats.
#include <algorithm>
#include <fstream>
#include <map>

#include <nlohmann/json.hpp>

#include "vtk_lattice.hpp"
#include "vtk_xml_data.hpp"

namespace isoextract_vtk {
namespace {

struct Step {
  double time = 0;
  std::string path;
};

std::vector<Step> steps_of_pvd(const std::string& path) {
  const XmlDocument document(path);
  std::map<double, std::string> steps;
  std::uint64_t count = 0;
  for (vtkXMLDataElement* element : children_of(document.body(), "DataSet")) {
    const std::string text = attribute_of(element, "timestep");
    const auto time = text.empty() ? std::optional<double>(static_cast<double>(count)) : parse_number(text);
    if (!time || !std::isfinite(*time))
      throw ReadError("expected a number as timestep, found '" + text.substr(0, 40) + "'");
    if (!steps.emplace(*time, path_beside(path, attribute_of(element, "file"))).second) {
      throw ReadError("expected one file per time step, found several parts of step " + printed(*time));
    }
    ++count;
  }
  std::vector<Step> sorted;
  for (const auto& [time, file] : steps) sorted.push_back({time, file});
  return sorted;
}

std::vector<Step> steps_of_series(const std::string& path) {
  std::ifstream stream(path);
  const auto json = nlohmann::json::parse(stream, nullptr, false);
  const auto files = json.is_object() ? json.find("files") : json.end();
  if (json.is_discarded() || !json.is_object() || files == json.end() || !files->is_array()) {
    throw ReadError("expected JSON with a list of files, found other text");
  }
  std::vector<Step> steps;
  for (const auto& entry : *files) {
    if (!entry.is_object() || !entry.contains("name") || !entry["name"].is_string()) {
      throw ReadError("expected a name and a time for each file, found another entry");
    }
    const bool timed = entry.contains("time") && entry["time"].is_number();
    steps.push_back({timed ? entry["time"].get<double>() : static_cast<double>(steps.size()),
                     path_beside(path, entry["name"].get<std::string>())});
  }
  std::ranges::stable_sort(steps, {}, &Step::time);
  return steps;
}

class TimeSeries final : public VolumeFile {
 public:
  TimeSeries(const Request& request, const isoextract_plugin_host& host) : request_(request) {
    const bool is_xml = InputFile(request.path).text_at(0, 1024).find("<VTKFile") != std::string::npos;
    steps_ = is_xml ? steps_of_pvd(request.path) : steps_of_series(request.path);
    if (steps_.empty()) throw ReadError("expected time steps, found none");
    open_step(request.volume, host);
    format = (is_xml ? "ParaView collection of " : "ParaView series of ") + inner_->format;
    creator = inner_->creator;
    note = inner_->note;
    grids = inner_->grids;
    for (const Step& step : steps_) files.push_back(step.path);
    for (Grid& grid : grids) {
      grid.volumes = steps_.size();
      grid.volume_times.clear();
      for (const Step& step : steps_) grid.volume_times.push_back(step.time);
    }
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    if (selection.volume != opened_) {
      open_step(selection.volume, host);
      const auto same = [](const Grid& a, const Grid& b) {
        return a.name == b.name && a.dims == b.dims && a.sample_type == b.sample_type && a.components == b.components;
      };
      if (!std::ranges::equal(inner_->grids, grids, same)) {
        throw ReadError("expected time steps with the grids and the box of the listed one, found others in step " +
                        std::to_string(selection.volume));
      }
    }
    isoextract_volume_selection inside = selection;
    inside.volume = 0;
    return inner_->read(inside, host);
  }

 private:
  void open_step(std::uint64_t step, const isoextract_plugin_host& host) {
    if (step >= steps_.size()) {
      throw ReadError("expected one of " + std::to_string(steps_.size()) + " time steps, found number " +
                      std::to_string(step));
    }
    Request inside = request_;
    inside.path = steps_[step].path;
    inside.volume = 0;
    const std::string start = InputFile(inside.path).text_at(0, 1024);
    if (start.find("type=\"Collection\"") != std::string::npos || inside.path.ends_with(".series")) {
      throw ReadError("expected files with grids, found a series in a series");
    }
    inner_ = open_volume(inside, host);
    opened_ = step;
  }

  Request request_;
  std::vector<Step> steps_;
  Opened inner_;
  std::uint64_t opened_ = 0;
};

}  // namespace

Opened open_time_series(const Request& request, const isoextract_plugin_host& host) {
  return std::make_unique<TimeSeries>(request, host);
}

}  // namespace isoextract_vtk

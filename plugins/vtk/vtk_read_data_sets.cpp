// Reads data sets with VTK's readers: legacy files, XML of all grids but image data, blocks, AMR and OpenFOAM cases.
#include <algorithm>
#include <filesystem>

#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkImageData.h>
#include <vtkOpenFOAMReader.h>
#include <vtkUniformGrid.h>
#include <vtkUniformGridAMR.h>
#include <vtkXMLMultiBlockDataReader.h>
#include <vtkXMLPRectilinearGridReader.h>
#include <vtkXMLPStructuredGridReader.h>
#include <vtkXMLPUnstructuredGridReader.h>
#include <vtkXMLRectilinearGridReader.h>
#include <vtkXMLStructuredGridReader.h>
#include <vtkXMLUniformGridAMRReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include "vtk_data_sets.hpp"
#include "vtk_messages.hpp"
#include "vtk_xml_data.hpp"

namespace isoextract_vtk {
namespace {

namespace fs = std::filesystem;

// Adds the leaves of any output. Leaves of finer AMR levels come first: an earlier leaf has precedence in an overlap.
void add_leaves(vtkDataObject* output, DataSets& data) {
  const auto add = [&](vtkDataObject* object) {
    auto* leaf = vtkDataSet::SafeDownCast(object);
    if (leaf != nullptr && leaf->GetNumberOfPoints() > 0) data.leaves.emplace_back(leaf);
  };
  if (auto* levels = vtkUniformGridAMR::SafeDownCast(output)) {
    for (unsigned level = levels->GetNumberOfLevels(); level-- > 0;) {
      for (unsigned i = 0; i < levels->GetNumberOfDataSets(level); ++i) add(levels->GetDataSet(level, i));
    }
  } else if (auto* blocks = vtkCompositeDataSet::SafeDownCast(output)) {
    auto at = vtkSmartPointer<vtkCompositeDataIterator>::Take(blocks->NewIterator());
    for (at->InitTraversal(); !at->IsDoneWithTraversal(); at->GoToNextItem()) add(at->GetCurrentDataObject());
  } else {
    add(output);
  }
}

void check_messages() {
  if (!vtk_messages().empty()) throw ReadError("VTK cannot read the file: " + first_sentence(vtk_messages()));
}

template <class Reader>
vtkDataObject* read_with(Reader& reader, const std::string& path) {
  reader->SetFileName(path.c_str());
  reader->Update();
  check_messages();
  if (reader->GetErrorCode() != 0) throw ReadError("VTK cannot read the file: it is damaged");
  return reader->GetOutputDataObject(0);
}

template <class Reader>
void read_all(const std::string& path, const char* format, DataSets& data) {
  auto reader = vtkSmartPointer<Reader>::New();
  add_leaves(read_with(reader, path), data);
  data.format = format;
}

// VTK allocates memory by the numbers in a legacy header before it reads.
void check_legacy_header(const InputFile& file) {
  const std::string start = file.text_at(0, 8192);
  const auto check = [&](const char* key, std::size_t numbers, std::uint64_t most) {
    const std::size_t at = start.find(key);
    if (at == std::string::npos) return;
    const std::string line = start.substr(at + 1, start.find('\n', at + 1) - at - 1);
    const auto words = words_of(line);
    std::vector<std::uint64_t> counts;
    for (std::size_t i = 1; i <= numbers && i < words.size(); ++i) {
      const auto count = parse_integer(words[i]);
      if (!count || *count < 0) throw ReadError("expected numbers of points, found '" + line.substr(0, 60) + "'");
      counts.push_back(static_cast<std::uint64_t>(*count));
    }
    if (counts.size() != numbers || !product(counts, most)) {
      throw ReadError("expected at most as many points as fit into the file's " + std::to_string(file.size()) +
                      " bytes, found '" + line.substr(0, 60) + "'");
    }
  };
  // A sample is at least a bit, a coordinate at least a byte.
  check("\nDIMENSIONS", 3, file.size() * 8);
  check("\nPOINTS", 1, file.size() / 3);
  check("\nX_COORDINATES", 1, file.size());
  check("\nY_COORDINATES", 1, file.size());
  check("\nZ_COORDINATES", 1, file.size());
}

void read_legacy(const std::string& path, DataSets& data) {
  check_legacy_header(InputFile(path));
  auto reader = vtkSmartPointer<vtkGenericDataObjectReader>::New();
  reader->ReadAllScalarsOn();
  reader->ReadAllVectorsOn();
  reader->ReadAllNormalsOn();
  reader->ReadAllTensorsOn();
  reader->ReadAllColorScalarsOn();
  reader->ReadAllTCoordsOn();
  reader->ReadAllFieldsOn();
  vtkDataObject* output = read_with(reader, path);
  if (output == nullptr) throw ReadError("expected a data set of VTK, found none");
  const std::string type = output->GetClassName();
  data.format = "VTK legacy";
  if (type == "vtkImageData" || type == "vtkStructuredPoints") data.format = "VTK legacy structured points";
  if (type == "vtkRectilinearGrid") data.format = "VTK legacy rectilinear grid";
  if (type == "vtkStructuredGrid") data.format = "VTK legacy structured grid";
  if (type == "vtkUnstructuredGrid") data.format = "VTK legacy unstructured grid";
  add_leaves(output, data);
}

// Collects the files that parallel and multi-block files name, for reports.
void collect_sources(const std::string& path, vtkXMLDataElement* element, std::vector<std::string>& files) {
  for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* child = element->GetNestedElement(i);
    for (const char* name : {"Source", "file"}) {
      const std::string source = attribute_of(child, name);
      if (!source.empty()) files.push_back(path_beside(path, source));
    }
    collect_sources(path, child, files);
  }
}

void read_xml(const std::string& path, DataSets& data) {
  std::string type;
  {
    const XmlDocument document(path);
    type = document.type();
    collect_sources(path, document.root(), data.files);
  }
  for (const std::string& file : data.files) InputFile{file};  // fails if missing; VTK would skip the file
  if (type == "RectilinearGrid") {
    read_all<vtkXMLRectilinearGridReader>(path, "VTK rectilinear grid", data);
  } else if (type == "PRectilinearGrid") {
    read_all<vtkXMLPRectilinearGridReader>(path, "VTK rectilinear grid (parallel)", data);
  } else if (type == "StructuredGrid") {
    read_all<vtkXMLStructuredGridReader>(path, "VTK structured grid", data);
  } else if (type == "PStructuredGrid") {
    read_all<vtkXMLPStructuredGridReader>(path, "VTK structured grid (parallel)", data);
  } else if (type == "UnstructuredGrid") {
    read_all<vtkXMLUnstructuredGridReader>(path, "VTK unstructured grid", data);
  } else if (type == "PUnstructuredGrid") {
    read_all<vtkXMLPUnstructuredGridReader>(path, "VTK unstructured grid (parallel)", data);
  } else if (type == "vtkMultiBlockDataSet") {
    read_all<vtkXMLMultiBlockDataReader>(path, "VTK multi-block data", data);
  } else if (type == "vtkOverlappingAMR" || type == "vtkNonOverlappingAMR" || type == "vtkHierarchicalBoxDataSet") {
    auto reader = vtkSmartPointer<vtkXMLUniformGridAMRReader>::New();
    reader->SetMaximumLevelsToReadByDefault(0);  // all
    add_leaves(read_with(reader, path), data);
    data.format = "VTK AMR";
  } else {
    throw ReadError("expected a grid of VTK, found the type " + type.substr(0, 40));
  }
}

bool is_open_foam(const std::string& path) { return fs::is_directory(path) || fs::path(path).extension() == ".foam"; }

void read_open_foam(const Request& request, DataSets& data) {
  const fs::path path(request.path);
  const fs::path folder = fs::is_directory(path) ? path : path.parent_path();
  const fs::path control = folder / "system" / "controlDict";
  if (!fs::exists(control)) throw ReadError("expected an OpenFOAM case with system/controlDict, found none");
  data.files.push_back(control.string());
  auto reader = vtkSmartPointer<vtkOpenFOAMReader>::New();
  reader->SetFileName(control.c_str());
  reader->SetDecomposePolyhedra(1);
  reader->SetCreateCellToPoint(0);  // it would list each array twice
  reader->UpdateInformation();
  check_messages();
  if (vtkDoubleArray* times = reader->GetTimeValues()) {
    data.times.assign(times->GetPointer(0), times->GetPointer(0) + times->GetNumberOfTuples());
  }
  reader->EnableAllCellArrays();
  reader->EnableAllPointArrays();
  reader->DisableAllPatchArrays();
  reader->SetPatchArrayStatus("internalMesh", 1);
  if (data.times.empty()) {
    reader->Update();
  } else {
    if (request.volume >= data.times.size())
      throw ReadError("expected one of " + std::to_string(data.times.size()) + " time steps, found another");
    reader->UpdateTimeStep(data.times[request.volume]);
  }
  check_messages();
  add_leaves(reader->GetOutputDataObject(0), data);
  data.format = "OpenFOAM case";
}

void add_field_time(DataSets& data) {
  for (const char* name : {"TimeValue", "TIME"}) {
    vtkDataArray* time = data.leaves[0]->GetFieldData()->GetArray(name);
    if (data.times.empty() && time != nullptr && time->GetNumberOfValues() == 1) data.times = {time->GetTuple1(0)};
  }
}

}  // namespace

Opened open_data_set(const Request& request, const isoextract_plugin_host& host) {
  vtk_messages().clear();
  DataSets data;
  if (is_open_foam(request.path)) {
    read_open_foam(request, data);
  } else {
    const std::string start = InputFile(request.path).text_at(0, 1024);
    if (start.starts_with("# vtk")) {
      read_legacy(request.path, data);
    } else {
      read_xml(request.path, data);
    }
  }
  if (data.leaves.empty()) throw ReadError("expected a grid with points, found none");
  add_field_time(data);
  HostMemory memory(host);
  for (const auto& leaf : data.leaves)
    memory.take(std::uint64_t{1024} * leaf->GetActualMemorySize());  // VTK reports KiB
  const std::vector<std::string> files = data.files;
  const std::vector<double> times = data.times;
  auto* rectilinear = vtkRectilinearGrid::SafeDownCast(data.leaves[0]);
  Opened volume = lattice_of(data);
  if (volume == nullptr && rectilinear != nullptr && data.leaves.size() == 1)
    volume = evened_grid(data, rectilinear, request);
  if (volume == nullptr) volume = resampled_cells(data, request, host);
  volume->files = files;
  for (Grid& grid : volume->grids) {
    grid.volumes = std::max<std::size_t>(1, times.size());
    grid.volume_times = times;
  }
  memory.keep();
  return volume;
}

}  // namespace isoextract_vtk

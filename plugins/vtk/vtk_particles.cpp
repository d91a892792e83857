// Particles in VTK files: the points of unstructured grids or poly data, legacy or XML, with their point data arrays.
// Rejects files with cells other than points, which are meshes.
#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <exception>
#include <fstream>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include <vtkAbstractArray.h>
#include <vtkCell.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <particle_plugin.h>

#include "vtk_messages.hpp"

namespace {

using isoextract_vtk::first_sentence;
using isoextract_vtk::silence_vtk;
using isoextract_vtk::vtk_messages;

thread_local std::string problem;  // of this thread's last call

struct PluginError : std::exception {
  explicit PluginError(std::string words) : text(std::move(words)) {}
  std::string text;
};

std::string start_of(const char* path) {
  std::ifstream file(path, std::ios::binary);
  std::string start(8192, '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(file.gcount()));
  return start;
}

std::uint64_t size_of(const char* path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  return file ? static_cast<std::uint64_t>(file.tellg()) : 0;
}

// VTK allocates memory for the number of points in a legacy header before it reads them.
void check_point_count(std::string_view start, std::uint64_t bytes) {
  const std::size_t at = start.find("\nPOINTS ");
  if (at == std::string_view::npos) return;
  const std::string_view text = start.substr(at + std::strlen("\nPOINTS "));
  std::uint64_t count = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), count);
  // A coordinate has at least a digit and a separator in text, and at least a byte in a binary file.
  if (status != std::errc{} || count > bytes / 3) {
    throw PluginError("expected at most as many points as fit into the file, found POINTS " +
                      std::string(text.substr(0, text.find('\n'))).substr(0, 40));
  }
}

vtkSmartPointer<vtkPointSet> read_points(const char* path) {
  const std::string start = start_of(path);
  vtk_messages().clear();
  vtkSmartPointer<vtkPointSet> points;
  const auto read = [&](auto reader) {
    reader->SetFileName(path);
    reader->Update();
    points = vtkPointSet::SafeDownCast(reader->GetOutputDataObject(0));
    if (reader->GetErrorCode() != 0 && vtk_messages().empty()) vtk_messages() = "the file is damaged";
  };
  if (start.starts_with("# vtk")) {
    check_point_count(start, size_of(path));
    auto reader = vtkSmartPointer<vtkGenericDataObjectReader>::New();
    reader->ReadAllScalarsOn();
    reader->ReadAllVectorsOn();
    reader->ReadAllNormalsOn();
    reader->ReadAllTensorsOn();
    reader->ReadAllFieldsOn();
    read(reader);
  } else if (start.find("\"PolyData\"") != std::string::npos) {
    read(vtkSmartPointer<vtkXMLPolyDataReader>::New());
  } else {
    read(vtkSmartPointer<vtkXMLUnstructuredGridReader>::New());
  }
  if (!vtk_messages().empty()) throw PluginError("VTK cannot read the file: " + first_sentence(vtk_messages()));
  if (points == nullptr) throw PluginError("expected an unstructured grid or poly data of VTK, found neither");
  return points;
}

bool is_point(int cell_type) {
  return cell_type == VTK_EMPTY_CELL || cell_type == VTK_VERTEX || cell_type == VTK_POLY_VERTEX;
}

// Returns the number of cells that are not points.
vtkIdType other_cells(vtkPointSet* points) {
  if (auto* poly = vtkPolyData::SafeDownCast(points)) {
    return poly->GetNumberOfLines() + poly->GetNumberOfPolys() + poly->GetNumberOfStrips();
  }
  vtkIdType count = 0;
  for (vtkIdType i = 0; i < points->GetNumberOfCells(); ++i) count += is_point(points->GetCellType(i)) ? 0 : 1;
  return count;
}

// An open file and its description.
struct Opened {
  vtkSmartPointer<vtkPointSet> points;
  std::vector<std::string> names;  // of the quantities and of their types
  std::vector<isoextract_particle_quantity> quantities;
};

// The file can mark one array as vectors and one as normals.
isoextract_attribute_kind kind_of(vtkPointData* data, vtkAbstractArray* array) {
  if (array == data->GetNormals()) return ISOEXTRACT_KIND_NORMAL;
  return array == data->GetVectors() ? ISOEXTRACT_KIND_VECTOR : ISOEXTRACT_KIND_NOT_SAID;
}

std::unique_ptr<Opened> open_points(const char* path) {
  auto opened = std::make_unique<Opened>();
  opened->points = read_points(path);
  if (const vtkIdType cells = other_cells(opened->points); cells > 0) {
    throw PluginError("expected particles, found a grid with " + std::to_string(cells) + " cells that are not points");
  }
  vtkPointData* data = opened->points->GetPointData();
  const int count = data->GetNumberOfArrays();
  opened->names.reserve(2 * static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    vtkAbstractArray* array = data->GetAbstractArray(i);
    if (array->GetNumberOfTuples() != opened->points->GetNumberOfPoints()) {
      throw PluginError("expected " + std::to_string(opened->points->GetNumberOfPoints()) +
                        " values of each array, found " + std::to_string(array->GetNumberOfTuples()));
    }
    const std::string& name = opened->names.emplace_back(array->GetName() == nullptr ? "" : array->GetName());
    const std::string& type = opened->names.emplace_back(array->GetDataTypeAsString());
    const bool is_numeric = vtkDataArray::SafeDownCast(array) != nullptr;
    opened->quantities.push_back({name.c_str(), type.c_str(),
                                  static_cast<std::uint64_t>(array->GetNumberOfComponents()), is_numeric ? 1 : 0,
                                  kind_of(data, array)});
  }
  return opened;
}

// Calls work(); turns its exceptions into texts. Returns 0 on success.
template <class F>
int catch_exceptions(F&& work) {
  try {
    silence_vtk();
    work();
    return 0;
  } catch (const PluginError& found) {
    problem = found.text;
  } catch (const std::bad_alloc&) {
    problem = "not enough memory to read it";
  } catch (const std::exception& error) {
    problem = error.what();
  }
  return 1;
}

Opened& opened_of(const isoextract_particle_file* file) { return *static_cast<Opened*>(file->owner); }

int open(const char* path, const char* /*grid*/, std::uint64_t frame, isoextract_particle_file* file) {
  return catch_exceptions([&] {
    *file = {};
    file->frames = 1;
    file->frame_name = file->length_unit = "";
    auto opened = std::make_unique<Opened>();
    if (frame == 0) opened = open_points(path);
    if (opened->points != nullptr) {
      file->particles = static_cast<std::uint64_t>(opened->points->GetNumberOfPoints());
      file->held_bytes = std::uint64_t{1024} * opened->points->GetActualMemorySize();  // VTK reports KiB
    }
    file->quantities = opened->quantities.data();
    file->quantity_count = opened->quantities.size();
    file->owner = opened.release();
  });
}

void close(isoextract_particle_file* file) { delete static_cast<Opened*>(file->owner); }

int positions(const isoextract_particle_file* file, double* values) {
  return catch_exceptions([&] {
    vtkPointSet* points = opened_of(file).points;
    for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i) points->GetPoint(i, values + 3 * i);
  });
}

int quantity(const isoextract_particle_file* file, std::size_t index, float* values) {
  return catch_exceptions([&] {
    vtkDataArray* array = opened_of(file).points->GetPointData()->GetArray(static_cast<int>(index));
    if (array == nullptr) throw PluginError("expected an array of numbers");
    const int components = array->GetNumberOfComponents();
    std::vector<double> tuple(static_cast<std::size_t>(components));
    for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) {
      array->GetTuple(i, tuple.data());
      values = std::ranges::transform(tuple, values, [](double v) { return static_cast<float>(v); }).out;
    }
  });
}

const char* error_text() { return problem.c_str(); }

constexpr isoextract_particle_plugin_v3 kPlugin{
    ISOEXTRACT_PARTICLE_PLUGIN_VERSION, "vtk", open, close, positions, quantity, error_text};

}  // namespace

const isoextract_particle_plugin_v3* isoextract_particle_plugin() { return &kPlugin; }

// VTK's filters on a vtkImageData that wraps the input's own memory.
#include <stdexcept>

#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkMarchingCubes.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkVersion.h>

#include "base/stopwatch.hpp"
#include "bench/contestant.hpp"

namespace isoextract::bench {
namespace {

int vtk_type_of(field::SampleType type) {
  switch (type) {
    case field::SampleType::u8: return VTK_UNSIGNED_CHAR;
    case field::SampleType::i8: return VTK_SIGNED_CHAR;
    case field::SampleType::u16: return VTK_UNSIGNED_SHORT;
    case field::SampleType::i16: return VTK_SHORT;
    case field::SampleType::u32: return VTK_UNSIGNED_INT;
    case field::SampleType::i32: return VTK_INT;
    case field::SampleType::f32: return VTK_FLOAT;
    case field::SampleType::f64: return VTK_DOUBLE;
    case field::SampleType::f16: break;
  }
  throw std::runtime_error("VTK has no samples of 16-bit floats");
}

std::uint64_t bytes_of(vtkDataArray* array) {
  if (array == nullptr) return 0;
  return static_cast<std::uint64_t>(array->GetNumberOfValues()) * static_cast<std::uint64_t>(array->GetDataTypeSize());
}

template <class Filter>
class VtkContestant : public Contestant {
 public:
  VtkContestant(const BenchmarkInput& input, bool normals, std::string name)
      : input_(input), normals_(normals), name_(std::move(name)) {
    const auto& samples = std::get<field::DenseSamples>(input.field.samples);
    const auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(vtk_type_of(samples.type)));
    constexpr int kNotYours = 1;
    array->SetVoidArray(const_cast<void*>(samples.data), static_cast<vtkIdType>(samples.count()), kNotYours);
    image_->SetDimensions(samples.dims.x, samples.dims.y, samples.dims.z);
    image_->GetPointData()->SetScalars(array);
  }

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] std::string program() const override { return std::string("VTK ") + vtkVersion::GetVTKVersion(); }

  Outcome run() override {
    const vtkNew<Filter> filter;
    filter->SetInputData(image_);
    filter->SetValue(0, input_.iso);
    filter->SetComputeNormals(normals_);
    filter->ComputeGradientsOff();
    filter->ComputeScalarsOff();
    const Stopwatch watch;
    filter->Update();
    const double seconds = watch.elapsed().wall_seconds;
    vtkPolyData* const mesh = filter->GetOutput();
    vtkCellArray* const triangles = mesh->GetPolys();
    const std::uint64_t written = bytes_of(mesh->GetPoints()->GetData()) +
                                  bytes_of(mesh->GetPointData()->GetNormals()) +
                                  bytes_of(triangles->GetConnectivityArray()) + bytes_of(triangles->GetOffsetsArray());
    return {1000 * seconds, static_cast<std::uint64_t>(triangles->GetNumberOfCells()),
            static_cast<std::uint64_t>(mesh->GetNumberOfPoints()), sample_bytes(input_), written};
  }

 private:
  const BenchmarkInput& input_;
  bool normals_;
  std::string name_;
  vtkNew<vtkImageData> image_;
};

}  // namespace

Contestants vtk_contestants(const BenchmarkInput& input, bool smooth_normals) {
  Contestants contestants;
  if (std::holds_alternative<field::DenseSamples>(input.field.samples)) {
    contestants.push_back(std::make_unique<VtkContestant<vtkFlyingEdges3D>>(input, smooth_normals, "FlyingEdges3D"));
    contestants.push_back(std::make_unique<VtkContestant<vtkMarchingCubes>>(input, smooth_normals, "MarchingCubes"));
  }
  return contestants;
}

}  // namespace isoextract::bench

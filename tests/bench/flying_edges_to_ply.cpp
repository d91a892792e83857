// What a user of VTK would write to get a PLY file from a raw one; scripts/compare_speed.py times isoextract beside it.
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include <vtkFlyingEdges3D.h>
#include <vtkImageReader2.h>
#include <vtkNew.h>
#include <vtkPLYWriter.h>
#include <vtkPolyData.h>
#include <vtkVersion.h>

#include <CLI/CLI.hpp>
#include "bench/vtk_threads.hpp"

int main(int argc, char** argv) {
  std::string input;
  std::string output;
  std::string type;
  std::array<int, 3> dims{};
  double iso = 0;
  CLI::App app("A raw file through VTK's FlyingEdges3D to a binary PLY file, on all threads");
  app.set_version_flag("--version", std::string("VTK ") + vtkVersion::GetVTKVersion() + ", SMP backend " +
                                        isoextract::bench::vtk_backend());
  app.add_option("INPUT", input, "Samples, x fastest, little-endian")->required()->check(CLI::ExistingFile);
  app.add_option("--dims", dims, "X,Y,Z")->required()->delimiter(',');
  app.add_option("--dtype", type, "u8, i16, u16 or f32")->required()->check(CLI::IsMember({"u8", "i16", "u16", "f32"}));
  app.add_option("--iso", iso, "Iso value")->required();
  app.add_option("-o", output, "The PLY file")->required();
  CLI11_PARSE(app, argc, argv);

  const vtkNew<vtkImageReader2> reader;
  reader->SetFileName(input.c_str());
  reader->SetFileDimensionality(3);
  reader->SetDataExtent(0, dims[0] - 1, 0, dims[1] - 1, 0, dims[2] - 1);
  reader->SetDataByteOrderToLittleEndian();
  if (type == "u8") reader->SetDataScalarTypeToUnsignedChar();
  if (type == "i16") reader->SetDataScalarTypeToShort();
  if (type == "u16") reader->SetDataScalarTypeToUnsignedShort();
  if (type == "f32") reader->SetDataScalarTypeToFloat();

  const vtkNew<vtkFlyingEdges3D> surface;
  surface->SetInputConnection(reader->GetOutputPort());
  surface->SetValue(0, iso);
  surface->ComputeNormalsOff();
  surface->ComputeGradientsOff();
  surface->ComputeScalarsOff();

  const vtkNew<vtkPLYWriter> writer;
  writer->SetInputConnection(surface->GetOutputPort());
  writer->SetFileName(output.c_str());
  writer->SetFileTypeToBinary();
  writer->SetDataByteOrderToLittleEndian();
  if (writer->Write() == 0) {
    std::fprintf(stderr, "flying_edges_to_ply: cannot write %s\n", output.c_str());
    return 1;
  }
  return 0;
}

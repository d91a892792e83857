#include "bench/vtk_threads.hpp"

#include <vtkSMPTools.h>

namespace isoextract::bench {

void set_vtk_threads(int threads) { vtkSMPTools::Initialize(threads); }

std::string vtk_backend() { return vtkSMPTools::GetBackend(); }

}  // namespace isoextract::bench

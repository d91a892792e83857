// VTK's threads. Apart, because VTK 9.1's vtkSMPTools.h is no valid C++20.
#pragma once

#include <string>

namespace isoextract::bench {

void set_vtk_threads(int threads);

// "TBB", "STDThread" or "Sequential": how Debian built VTK, unless VTK_SMP_BACKEND_IN_USE says otherwise.
std::string vtk_backend();

}  // namespace isoextract::bench

// Data sets that VTK has read into memory, and the volumes that are made of them.
#pragma once

#include <string>
#include <vector>

#include <vtkDataSet.h>
#include <vtkRectilinearGrid.h>
#include <vtkSmartPointer.h>

#include "vtk_lattice.hpp"

namespace isoextract_vtk {

struct DataSets {
  std::string format;
  std::string note;
  std::vector<vtkSmartPointer<vtkDataSet>> leaves;  // where cells overlap, resampled_cells() reads the earlier leaf
  std::vector<double> times;                        // of all time steps; empty if the file states none
  std::vector<std::string> files;                   // besides the input
};

// Returns the arrays of all leaves, each name once, without ghost arrays; arrays without numbers as not scalar. Throws
// if there are none.
std::vector<ArrayFacts> arrays_of(const std::vector<vtkSmartPointer<vtkDataSet>>& leaves);

// Returns the array of a data set, or null. Throws if it has too many or too few values.
vtkDataArray* find_array(vtkDataSet* data, const ArrayFacts& facts);

// Returns the values of an array as doubles.
std::vector<double> values_of(vtkDataArray* array);

// Stores a component of a tuple, or its length, as sample `index` of the selection's box, which has f32 or f64 samples.
void put_tuple(const Grid& grid, const isoextract_volume_selection& selection, std::uint64_t index,
               const double* tuple);

// Returns the leaves as one lattice in memory, and takes them from `data`; null if they are not all image data or
// evenly spaced rectilinear grids on one lattice.
Opened lattice_of(DataSets& data);

// Resamples a rectilinear grid trilinearly onto an even lattice with its smallest distances, enlarged as needed to make
// at most 4 times the samples. Throws UnevenError, with the distances, unless request.resamples is set.
Opened evened_grid(DataSets& data, vtkRectilinearGrid* grid, const Request& request);

// Resamples cells of any kind with a volume onto a box of samples; NaN outside the cells. Throws if there are none.
Opened resampled_cells(DataSets& data, const Request& request, const isoextract_plugin_host& host);

// Returns whether coordinates are even, within a ten-thousandth of a step or the rounding of floats or doubles.
bool is_even(const std::vector<double>& coordinates, bool single_precision);
// Throws unless the axis has a finite coordinate for each point, which all increase or all decrease.
std::vector<double> coordinates_of(vtkRectilinearGrid* grid, std::size_t axis);
// Returns whether the coordinates along an axis are floats.
bool is_single_precision(vtkRectilinearGrid* grid, std::size_t axis);

}  // namespace isoextract_vtk

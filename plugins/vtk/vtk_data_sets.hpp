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
  std::vector<vtkSmartPointer<vtkDataSet>> leaves;  // where they overlap, an earlier one counts
  std::vector<double> times;                        // of all time steps; empty if the file states none
  std::vector<std::string> files;                   // besides the input
};

// Returns the arrays of all leaves: those that have numbers, and others as not scalar.
std::vector<ArrayFacts> arrays_of(const std::vector<vtkSmartPointer<vtkDataSet>>& leaves);

// Returns the array of a data set, or null.
vtkDataArray* find_array(vtkDataSet* data, const ArrayFacts& facts);

// Returns the values of an array as doubles.
std::vector<double> values_of(vtkDataArray* array);

// Stores a component of a tuple, or its length, as sample `index` of the selection's box, which has f32 or f64 samples.
void put_tuple(const Grid& grid, const isoextract_volume_selection& selection, std::uint64_t index,
               const double* tuple);

// Lattices in memory; null if the leaves are not image data, or evenly spaced rectilinear grids, on one lattice.
Opened lattice_of(DataSets& data);

// Resamples a rectilinear grid with uneven distances trilinearly onto the finest even lattice of at most 4 times the
// samples. Fails, with the distances, unless the request allows that.
Opened evened_grid(DataSets& data, vtkRectilinearGrid* grid, const Request& request);

// Resamples cells of any kind onto a box of samples; NaN outside the cells.
Opened resampled_cells(DataSets& data, const Request& request, const isoextract_plugin_host& host);

// Returns whether coordinates have even distances, within the rounding of their type.
bool is_even(const std::vector<double>& coordinates, bool single_precision);
std::vector<double> coordinates_of(vtkRectilinearGrid* grid, std::size_t axis);
bool is_single_precision(vtkRectilinearGrid* grid);

}  // namespace isoextract_vtk

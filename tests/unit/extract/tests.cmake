isoextract_unit_test(extract
  border_test.cpp cell_tables_test.cpp convergence_test.cpp edge_keys_test.cpp exact_topology_test.cpp inside_test_test.cpp invariants_test.cpp label_nets_test.cpp
  memory_test.cpp nan_hole_test.cpp nan_test.cpp normals_test.cpp placement_test.cpp region_test.cpp sparse_test.cpp threads_test.cpp
  vectorised_test.cpp voxels_sparse_test.cpp voxels_test.cpp)

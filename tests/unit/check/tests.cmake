isoextract_unit_test(check
  mesh_check_test.cpp self_intersections_test.cpp)

isoextract_unit_test(accuracy
  attribute_match_test.cpp analytic_error_test.cpp extraction_comparison_test.cpp field_error_test.cpp
  mesh_distance_test.cpp mesh_match_test.cpp resolution_test.cpp surface_coverage_test.cpp)

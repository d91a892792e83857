isoextract_unit_test(measure
  attribute_match_test.cpp
  analytic_error_test.cpp benchmark_test.cpp extraction_comparison_test.cpp field_error_test.cpp
  mesh_check_test.cpp mesh_distance_test.cpp mesh_match_test.cpp method_traits_test.cpp resolution_test.cpp
  self_intersections_test.cpp stability_test.cpp surface_coverage_test.cpp reference_size_test.cpp)

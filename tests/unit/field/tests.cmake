isoextract_unit_test(field
  blur_test.cpp coarsen_test.cpp demo_field_test.cpp interpolant_test.cpp no_data_test.cpp percentiles_test.cpp
  point_samples_test.cpp resample_test.cpp
    statistics_test.cpp
  surface_estimate_test.cpp)

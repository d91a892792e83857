find_package(ZLIB REQUIRED)

isoextract_unit_test(points
  attribute_sampling_test.cpp cell_grid_test.cpp kernel_test.cpp memory_test.cpp particle_field_test.cpp
  particle_statistics_test.cpp sphere_set_test.cpp surface_test.cpp weight_test.cpp)
target_link_libraries(test_points PRIVATE isoextract_extract isoextract_accuracy ZLIB::ZLIB)

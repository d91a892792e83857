isoextract_unit_test(gpu
  case_constants_test.cpp device_test.cpp drawing_thread_test.cpp flat_normals_test.cpp parity_test.cpp
  resident_samples_test.cpp site_weld_test.cpp slabs_test.cpp
  sparse_source_test.cpp toroidal_window_test.cpp whole_fields_test.cpp)
target_link_libraries(test_gpu PRIVATE isoextract_bench isoextract_volume_io)

# device_test runs it where drivers are missing or broken.
add_executable(gpu_device_probe unit/gpu/device_probe.cpp)
target_link_libraries(gpu_device_probe PRIVATE isoextract_gpu isoextract_options)
add_library(gpu_no_functions MODULE unit/gpu/no_functions.cpp)
add_dependencies(test_gpu gpu_device_probe gpu_no_functions)
target_compile_definitions(test_gpu PRIVATE
  ISOEXTRACT_DEVICE_PROBE="$<TARGET_FILE:gpu_device_probe>" ISOEXTRACT_NO_FUNCTIONS="$<TARGET_FILE:gpu_no_functions>")

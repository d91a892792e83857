target_link_libraries(test_gpu PRIVATE isoextract_bench isoextract_volume_io)

# device_test runs it in environments with missing or broken drivers.
add_executable(gpu_device_probe unit/gpu/programs/device_probe.cpp)
target_link_libraries(gpu_device_probe PRIVATE isoextract_gpu isoextract_options)
add_library(gpu_no_functions MODULE unit/gpu/programs/no_functions.cpp)
add_dependencies(test_gpu gpu_device_probe gpu_no_functions)
target_compile_definitions(test_gpu PRIVATE
  ISOEXTRACT_DEVICE_PROBE="$<TARGET_FILE:gpu_device_probe>" ISOEXTRACT_NO_FUNCTIONS="$<TARGET_FILE:gpu_no_functions>")

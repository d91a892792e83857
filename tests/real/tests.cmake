# Real volumes by others against figures of VTK's FlyingEdges3D on the same voxels; says so where the data is missing.
find_package(nlohmann_json REQUIRED)
add_executable(test_real real/real_volumes_test.cpp)
target_link_libraries(test_real PRIVATE
  isoextract_volume_io isoextract_extract isoextract_options nlohmann_json::nlohmann_json GTest::gtest_main)
target_include_directories(test_real PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_compile_definitions(test_real PRIVATE ISOEXTRACT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
gtest_discover_tests(test_real DISCOVERY_MODE PRE_TEST TEST_PREFIX real.)

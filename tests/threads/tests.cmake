# All rooms from a volume file to a mesh file, on one thread and on several.
add_executable(test_threads threads/whole_way_test.cpp)
target_link_libraries(test_threads PRIVATE
  isoextract_volume_io isoextract_extract isoextract_mesh_io isoextract_options GTest::gtest_main)
target_include_directories(test_threads PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_compile_definitions(test_threads PRIVATE ISOEXTRACT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
gtest_discover_tests(test_threads DISCOVERY_MODE PRE_TEST TEST_PREFIX threads.)

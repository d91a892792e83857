include(${PROJECT_SOURCE_DIR}/cmake/OpenVDB.cmake)

isoextract_unit_test(volume_io
  array_reader_test.cpp component_reader_test.cpp npz_reader_test.cpp mapped_samples_test.cpp nifti_reader_test.cpp npy_reader_test.cpp nrrd_reader_test.cpp
  raw_reader_test.cpp
  real_files_reader_test.cpp volume_choice_test.cpp volume_reader_test.cpp volume_writer_test.cpp
    plugin_volumes_test.cpp
    label_table_test.cpp)
# Together these files take the compiler very much longer than one by one.
set_target_properties(test_volume_io PROPERTIES UNITY_BUILD OFF)
target_sources(test_volume_io PRIVATE support/plugin_reader_main.cpp)

# OpenVDB's templates take the compiler longer than the tests take; without optimisation the tests take longer still.
add_library(vdb_reader_tests OBJECT
  unit/volume_io/openvdb_plugin_test.cpp unit/volume_io/openvdb_tools_test.cpp
  unit/volume_io/vdb_damage_reader_test.cpp unit/volume_io/vdb_list_reader_test.cpp unit/volume_io/vdb_reader_test.cpp unit/volume_io/vdb_tree_reader_test.cpp)
target_compile_options(vdb_reader_tests PRIVATE -O1)
target_include_directories(vdb_reader_tests PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(vdb_reader_tests PRIVATE isoextract_volume_io isoextract_options GTest::gtest openvdb_library)
isoextract_see_all(vdb_reader_tests volume_io)
target_compile_definitions(vdb_reader_tests PRIVATE ISOEXTRACT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
target_link_libraries(test_volume_io PRIVATE vdb_reader_tests openvdb_library)

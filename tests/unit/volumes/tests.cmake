include(${PROJECT_SOURCE_DIR}/cmake/OpenVDB.cmake)

isoextract_unit_test(volumes
  mapped_samples_test.cpp nifti_reader_test.cpp npy_reader_test.cpp nrrd_reader_test.cpp plugin_host_test.cpp raw_reader_test.cpp
  real_files_reader_test.cpp vdb_damage_reader_test.cpp vdb_list_reader_test.cpp vdb_reader_test.cpp
  vdb_tree_reader_test.cpp volume_reader_test.cpp)
target_link_libraries(test_volumes PRIVATE openvdb_library)
# OpenVDB's headers take the compiler longer than the tests; the other files take it very much longer together.
set_target_properties(test_volumes PROPERTIES UNITY_BUILD_MODE GROUP)
set_source_files_properties(unit/volumes/vdb_damage_reader_test.cpp unit/volumes/vdb_list_reader_test.cpp
  unit/volumes/vdb_reader_test.cpp unit/volumes/vdb_tree_reader_test.cpp PROPERTIES UNITY_GROUP openvdb)

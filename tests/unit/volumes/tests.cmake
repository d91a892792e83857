include(${PROJECT_SOURCE_DIR}/cmake/OpenVDB.cmake)

isoextract_unit_test(volumes
  mapped_samples_test.cpp nifti_reader_test.cpp npy_reader_test.cpp nrrd_reader_test.cpp raw_reader_test.cpp
  real_files_reader_test.cpp volume_reader_test.cpp)

# OpenVDB's headers take longer to compile than all of the above: the sanitizers' subset leaves these out.
isoextract_unit_test(volumes PROGRAM test_volumes_vdb
  vdb_damage_reader_test.cpp vdb_reader_test.cpp vdb_tree_reader_test.cpp)
target_link_libraries(test_volumes_vdb PRIVATE openvdb_library)

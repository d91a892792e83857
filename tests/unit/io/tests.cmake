find_package(TinyGLTF REQUIRED)
include(${PROJECT_SOURCE_DIR}/cmake/OpenVDB.cmake)

isoextract_unit_test(io
  gltf_writer_test.cpp
  mapped_samples_test.cpp
  mesh_file_parsers.cpp
  mesh_reader_test.cpp
  mesh_writer_test.cpp
  number_text_test.cpp
  obj_writer_test.cpp
  output_file_test.cpp
  ply_writer_test.cpp
  stl_writer_test.cpp
  nifti_reader_test.cpp
  npy_reader_test.cpp
  nrrd_reader_test.cpp
  raw_reader_test.cpp
  real_files_reader_test.cpp
  vdb_damage_reader_test.cpp
  vdb_reader_test.cpp
  vdb_tree_reader_test.cpp
  volume_reader_test.cpp)
target_link_libraries(test_io PRIVATE TinyGLTF::TinyGLTF openvdb_library)

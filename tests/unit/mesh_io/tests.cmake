find_package(TinyGLTF REQUIRED)

isoextract_unit_test(mesh_io
  animation_writer_test.cpp attributes_test.cpp context_test.cpp gltf_writer_test.cpp mesh_file_parsers.cpp
  mesh_reader_test.cpp mesh_writer_test.cpp number_text_test.cpp
  other_programs_test.cpp packing_test.cpp
  obj_writer_test.cpp ply_writer_test.cpp stl_writer_test.cpp written_places_test.cpp)
target_link_libraries(test_mesh_io PRIVATE TinyGLTF::TinyGLTF)

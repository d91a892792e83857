find_package(TinyGLTF REQUIRED)

target_link_libraries(test_mesh_io PRIVATE TinyGLTF::TinyGLTF)

isoextract_unit_test(render
  camera_test.cpp compositing_test.cpp golden_test.cpp gpu_picture_test.cpp gpu_renderer_test.cpp kept_volume_test.cpp
  preview_test.cpp scene_test.cpp shading_test.cpp skipping_test.cpp transfer_function_test.cpp vectorised_test.cpp
  volume_nodes_test.cpp)
target_link_libraries(test_render PRIVATE isoextract_image_io)

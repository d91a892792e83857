isoextract_unit_test(edit bounded_simplify_test.cpp triangle_count_test.cpp cut_cap_test.cpp half_space_clip_test.cpp loop_triangulation_test.cpp pieces_test.cpp smooth_test.cpp
    colormap_test.cpp vertex_colors_test.cpp)
target_link_libraries(test_edit PRIVATE isoextract_extract isoextract_accuracy)

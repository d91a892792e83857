isoextract_unit_test(batch animation_test.cpp find_frames_test.cpp frame_pattern_test.cpp frame_queue_test.cpp frame_range_test.cpp iso_table_test.cpp natural_order_test.cpp manifest_test.cpp output_names_test.cpp
  scheduler_test.cpp sequences_test.cpp shard_test.cpp batch_run_test.cpp)

# The example of a batch from code that can be resumed.
add_executable(resumed_batch ${PROJECT_SOURCE_DIR}/samples/resumed_batch.cpp)
target_link_libraries(resumed_batch PRIVATE isoextract_batch isoextract_options)
add_test(NAME batch.example_of_a_resumed_batch COMMAND ${Python3_EXECUTABLE} -B
  ${CMAKE_CURRENT_LIST_DIR}/resumed_batch_test.py $<TARGET_FILE:resumed_batch> $<TARGET_FILE:isoextract>)

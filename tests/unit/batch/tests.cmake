isoextract_unit_test(batch animation_test.cpp find_frames_test.cpp frame_pattern_test.cpp frame_queue_test.cpp frame_range_test.cpp iso_table_test.cpp natural_order_test.cpp manifest_test.cpp output_names_test.cpp
  scheduler_test.cpp sequences_test.cpp shard_test.cpp batch_run_test.cpp)

# Builds samples/resumed_batch and checks that it resumes a batch.
add_executable(resumed_batch ${PROJECT_SOURCE_DIR}/samples/resumed_batch.cpp)
target_link_libraries(resumed_batch PRIVATE isoextract_batch isoextract_options)
add_test(NAME batch.example_of_a_resumed_batch COMMAND ${Python3_EXECUTABLE} -B
  ${CMAKE_CURRENT_LIST_DIR}/resumed_batch_test.py $<TARGET_FILE:resumed_batch> $<TARGET_FILE:isoextract>)

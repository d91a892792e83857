add_subdirectory(${PROJECT_SOURCE_DIR}/examples ${PROJECT_BINARY_DIR}/examples)
add_test(NAME examples.resumed_batch COMMAND Python3::Interpreter -B
  ${CMAKE_CURRENT_LIST_DIR}/resumed_batch_test.py $<TARGET_FILE:resumed_batch> $<TARGET_FILE:isoextract>)

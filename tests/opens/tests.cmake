# How often the program opens its files. A library is put before all others, which sanitizers do not allow.
if(NOT ISOEXTRACT_SANITIZE)
  add_library(count_opens MODULE ${CMAKE_CURRENT_LIST_DIR}/count_opens.cpp)
  target_link_libraries(count_opens PRIVATE ${CMAKE_DL_LIBS})
  set_target_properties(count_opens PROPERTIES UNITY_BUILD OFF)
  add_test(NAME cli.opens COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/opens_test.py)
  set_tests_properties(cli.opens PROPERTIES
    ENVIRONMENT "ISOEXTRACT_PROGRAM=$<TARGET_FILE:isoextract>;ISOEXTRACT_SOURCE_DIR=${PROJECT_SOURCE_DIR};ISOEXTRACT_COUNT_OPENS=$<TARGET_FILE:count_opens>"
    TIMEOUT 1500)
endif()

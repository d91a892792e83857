# Whether the preset tsan sees a race where there is one, and none where there is none.
if(ISOEXTRACT_SANITIZE MATCHES "thread")
  find_package(TBB REQUIRED)
  add_executable(planted_race tsan/planted_race.cpp)
  target_link_libraries(planted_race PRIVATE TBB::tbb isoextract_options)
  add_test(NAME tsan.planted_race
    COMMAND Python3::Interpreter -B ${CMAKE_CURRENT_LIST_DIR}/planted_race_test.py $<TARGET_FILE:planted_race>)
endif()

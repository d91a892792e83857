# The thread sanitizer needs a oneTBB that was built with it. With another oneTBB the sanitizer does not see the
# library's synchronization and reports races on data that a loop hands to its bodies. A suppression would hide every
# race of the bodies as well. tests/tsan/planted_race_test.py shows both.
if(ISOEXTRACT_SANITIZE MATCHES "thread")
  set(TBB_DIR ${PROJECT_SOURCE_DIR}/build/tsan-tbb/lib/cmake/TBB CACHE PATH "oneTBB with the thread sanitizer" FORCE)
  find_package(TBB QUIET NO_DEFAULT_PATH)
  if(NOT TBB_FOUND)
    message(FATAL_ERROR "There is no oneTBB with the thread sanitizer: `scripts/tsan_tbb` builds it")
  endif()
endif()
